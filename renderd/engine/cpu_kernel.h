#pragma once

#include <cstdint>

#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// One sample of each pixel of a tile.
struct CpuTile {
  std::uint32_t x0, y0, x1, y1;  ///< pixels [x0, x1) x [y0, y1)
  std::uint64_t sample;          ///< number in the random stream
  Sample* samples;               ///< of the whole picture, rows from the top
  Guides* guides;                ///< likewise, of a kernel with Feature::kGuides; else unused
};

using CpuVolumeView = LinearVolume;
using CpuScene = SceneView<CpuVolumeView>;
using CpuKernel = void (*)(const CpuScene&, const CpuTile&);

/// The kernel compiled for a set of features and for this processor's instructions.
/// `exact`: by the exact walk instead of tracking.
CpuKernel cpu_kernel(Features features, bool exact = false);
/// "AVX2" or "baseline", for reports.
const char* cpu_instructions();

/// The same sources compiled twice (cpu_kernel_avx2.cpp, cpu_kernel_baseline.cpp).
CpuKernel cpu_kernel_baseline(Features features, bool exact);
CpuKernel cpu_kernel_avx2(Features features, bool exact);

}  // namespace diaphane::render
