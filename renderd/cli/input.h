#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// Reads INPUT by what it is: a directory of the volume store, a folder of DICOM files, or a file
/// of a format that the image readers know. kNotFound: nothing there; kUnsupported: no reader for
/// it in this build.
Result<volume::Volume> read_input(const std::string& path);

}  // namespace diaphane::render::cli
