#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// The phase of a scan to render.
struct PhaseChoice {
  std::uint32_t index = 0;
  bool must_exist = false;  ///< false: a scan with fewer phases shows its last one
};

/// Reads INPUT by its type: a directory of the volume store, a folder of DICOM files, or a file in
/// a format that the image readers support, and returns one of its phases. Fails with kNotFound if
/// it does not exist, with kUnsupported if this build has no reader for it, and with kInvalid if it
/// has no such phase.
Result<volume::Volume> read_input(const std::string& path, PhaseChoice phase = {});

/// Hides what surrounds the body (volume::hide_surroundings), by the labels that are stored with
/// the volume or that ingest/ finds.
Result<void> show_only_body(volume::Volume& volume);

}  // namespace diaphane::render::cli
