#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// Reads INPUT by its type: a directory of the volume store, a folder of DICOM files, or a file in
/// a format that the image readers support. Fails with kNotFound if it does not exist, and with
/// kUnsupported if this build has no reader for it.
Result<volume::Volume> read_input(const std::string& path);

/// Hides what surrounds the body (volume::hide_surroundings), by the labels that are stored with
/// the volume or that ingest/ finds.
Result<void> show_only_body(volume::Volume& volume);

}  // namespace diaphane::render::cli
