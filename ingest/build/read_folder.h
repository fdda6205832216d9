#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The suitable series with the most slices among the DICOM files under `path`, as a measured
/// Volume. kNotFound: no such folder; kInvalid, in the words that `diaphane scan` uses: nothing in
/// it is a volume.
Result<volume::Volume> read_folder(const std::string& path);

}  // namespace diaphane::ingest
