#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Reads the suitable series with the most slices among the DICOM files under `path`, as a measured
/// volume with all phases. Returns kNotFound if the folder does not exist, and kInvalid with the
/// message of `diaphane scan` if no series forms a volume.
Result<volume::Volume> read_folder(const std::string& path);

}  // namespace diaphane::ingest
