#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// True for the names of files that read_image reads: .mha, .mhd, .nii, .nii.gz, .nrrd.
bool is_image_name(const std::string& path);

/// One scalar volume from a file of another format (VTK's readers), as a measured Volume. Voxels of
/// 8 or 16 bits and floats become int16: integers as they are, floats rounded, all clamped with a
/// repair that says so. Left-handed axes are turned (one axis reversed), axes of NIfTI and NRRD are
/// brought to LPS. kNotFound: no such file; kInvalid: not what its name says, or damaged;
/// kUnsupported: vectors, time series, 32-bit integers, sheared axes; kTooLarge: more voxels than a
/// volume may have.
Result<volume::Volume> read_image(const std::string& path);

}  // namespace diaphane::ingest
