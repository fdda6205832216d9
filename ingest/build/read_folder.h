#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Reads the suitable series with the most slices among the DICOM files under `path`, as a measured
/// volume. kNotFound: the folder does not exist. kInvalid: no series forms a volume, with the same
/// message as `diaphane scan`.
Result<volume::Volume> read_folder(const std::string& path);

}  // namespace diaphane::ingest
