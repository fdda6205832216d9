#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Returns whether read_image reads files with this name: .mha, .mhd, .nii, .nii.gz, .nrrd.
bool is_image_name(const std::string& path);

/// Reads the volume of a file in a research format, with all of its phases, as a measured volume.
/// Voxels become int16: integers that fit are kept, floats are rounded, and other values are
/// scaled, with a repair note. One axis of left-handed axes is reversed, and the axes of NIfTI and
/// NRRD are converted to LPS. Returns
/// kNotFound if the file does not exist, kInvalid if it is damaged or not of the format in its
/// name, kUnsupported for vectors, 64-bit integers or sheared axes, and kTooLarge for more voxels
/// than a volume may have.
Result<volume::Volume> read_image(const std::string& path);

}  // namespace diaphane::ingest
