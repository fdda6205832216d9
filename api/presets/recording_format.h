#pragma once

#include "api/presets/recordings.h"
#include "api/routing/request_fields.h"

namespace diaphane::api {

/// Maximum number of JSON values in a recording: one per 8 bytes of the largest body (1 MB), which
/// take at most 21 MB as a tree. The page stays below it: it ends a recording at 500 KB, and a
/// camera of 16 values takes at least 200 bytes.
inline constexpr std::size_t kMostRecordingValues = 131'072;

/// Reads a recording (docs/contracts.md, "Recorded interaction") from a request and reports errors.
/// The stored form contains no personal data: names of materials and lights may be user input, and
/// textures are images, so both are removed.
Recording read_recording(Fields& in);

}  // namespace diaphane::api
