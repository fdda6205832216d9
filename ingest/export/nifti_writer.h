#pragma once

#include <span>

#include "common/result.h"
#include "ingest/export/sink.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Largest number of voxels along an axis of NIfTI-1, whose sizes are int16.
inline constexpr std::uint32_t kMostNiftiSide = 32767;

/// Writes a volume as NIfTI-1 (`.nii`, or `.nii.gz` with `compress`). The voxels are the stored
/// int16 values, unchanged and unscaled: Hounsfield units for CT. qform and sform both place the
/// voxels in the patient's space (RAS, millimetres), with code 1 (scanner) if the scan's position
/// is known. Otherwise the centre of the scan is the origin, and the code is 2 (aligned). The only
/// text is the modality, in intent_name.
///
/// Returns kTooLarge for more than kMostNiftiSide voxels along an axis, or an error of `sink`.
Result<void> write_nifti(const volume::Header& header, std::span<const std::int16_t> voxels,
                         bool compress, const Sink& sink);

}  // namespace diaphane::ingest
