#pragma once

#include <cstdint>

#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// A request for one sample of each pixel of a tile.
struct CpuTile {
  std::uint32_t x0, y0, x1, y1;  ///< pixels [x0, x1) x [y0, y1)
  std::uint64_t sample;          ///< number of the sample, from 0 (CpuFilm::drawn)
  Sample* samples;               ///< the samples of the whole picture, rows from the top
  Guides* guides;  ///< the guides of the whole picture, or null; needs Feature::kGuides
};

using CpuVolumeView = LinearVolume;
using CpuScene = SceneView<CpuVolumeView>;
using CpuKernel = void (*)(const CpuScene&, const CpuTile&);

/// Returns the kernel for a set of features and for the instruction set of this processor. `exact`
/// selects the exact walk instead of tracking.
CpuKernel cpu_kernel(Features features, bool exact = false);
/// Returns whether the processor has the instructions that cpu_kernel() needs, which is always true
/// if the build option DIAPHANE_PORTABLE is on.
bool cpu_suffices();
/// Returns the instruction set, "AVX2" or "baseline", for reports.
const char* cpu_instructions();

/// The two compilations of the same source (kernel_avx2.cpp, kernel_baseline.cpp).
CpuKernel cpu_kernel_baseline(Features features, bool exact);
CpuKernel cpu_kernel_avx2(Features features, bool exact);

}  // namespace diaphane::render
