#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Whether read_image reads files with this name: .mha, .mhd, .nii, .nii.gz, .nrrd.
bool is_image_name(const std::string& path);

/// Reads one scalar volume from a file of another format with VTK's readers, as a measured volume.
/// Voxels become int16: integers that fit are kept, floats are rounded, and what does not fit is
/// scaled, with a repair note. One axis of left-handed axes is reversed, and the axes of NIfTI
/// and NRRD are converted to LPS. kNotFound: the file does not exist. kInvalid: damaged, or not the
/// format that its name says. kUnsupported: vectors, time series, 64-bit integers or sheared axes.
/// kTooLarge: more voxels than a volume may have.
Result<volume::Volume> read_image(const std::string& path);

}  // namespace diaphane::ingest
