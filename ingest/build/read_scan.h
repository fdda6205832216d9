#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Reads a scan, with all phases, for a program on the command line: a stored volume, whose hash is
/// not verified, a folder of DICOM files (read_folder), or a file in a research format
/// (read_image). Returns kNotFound if there is nothing at `path`, kUnsupported for any other file,
/// and the errors of the reader.
Result<volume::Volume> read_scan(const std::string& path);

}  // namespace diaphane::ingest
