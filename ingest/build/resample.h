#pragma once

#include <cstdint>

#include "ingest/build/build_volume.h"
#include "ingest/dicom/classify.h"

namespace diaphane::ingest {

/// Resamples the slices in `built.volume` according to `found.sources` with VTK's reslice filter.
/// Interpolation is cubic within shifted slices (clamped to the slices' range) and linear between
/// slices. Voxels that no slice covers become `air` and are counted in `built.filler`. The volume's
/// size becomes `found.size`. It uses one thread, because the sandbox allows only one.
/// Precondition: `found` is suitable and has sources. Throws std::bad_alloc.
void resample(const dicom::Assessment& found, std::int16_t air, Built& built);

}  // namespace diaphane::ingest
