#pragma once

#include <cstdint>

#include "ingest/build/build_volume.h"
#include "ingest/dicom/classify.h"

namespace diaphane::ingest {

/// Carries out the plan `found.sources` on the slices in `built.volume`, with VTK's reslice filter:
/// cubic within slices that are shifted (cut to the range of the slices), linear from slice to
/// slice. What no slice covers becomes `air` and is counted in `built.filler`. The volume's size
/// becomes `found.size`. One thread: the sandbox allows no more. Precondition: `found` is suitable,
/// with sources; throws std::bad_alloc.
void resample(const dicom::Assessment& found, std::int16_t air, Built& built);

}  // namespace diaphane::ingest
