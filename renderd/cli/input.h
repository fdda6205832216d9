#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// Reads INPUT by its type: a directory of the volume store, a folder of DICOM files, or a file in
/// a format that the image readers support. kNotFound: it does not exist. kUnsupported: this build
/// has no reader for it. The volume has labels if it is stored with them or if this build
/// contains ingest/.
Result<volume::Volume> read_input(const std::string& path);

}  // namespace diaphane::render::cli
