#pragma once

#include <string>

#include "common/result.h"
#include "volume/alignment.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// Read a scan with ingest/. Fail with kUnsupported if it is not built in (scan_readers_none.cpp).
Result<volume::Volume> read_dicom_folder(const std::string& path);
Result<volume::Volume> read_image_file(const std::string& path);

Result<volume::LabelSet> read_label_file(const std::string& path, const volume::Header& scan);

/// Aligns two scans; `second` to `first`.
Result<volume::Matrix> align_scans(const volume::Volume& first, const volume::Volume& second);

/// Labels the body in a measured volume. Without ingest/, everything counts as body.
void add_labels(volume::Volume& volume);

}  // namespace diaphane::render::cli
