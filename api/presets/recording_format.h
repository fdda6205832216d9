#pragma once

#include "api/presets/recordings.h"
#include "api/routing/request_fields.h"

namespace diaphane::api {

/// Maximum values of a request: one per 8 bytes of the largest body (1 MB), which take at most 21
/// MB as a tree. Recordings of the page have fewer. It ends a recording at 500 KB, and a camera has
/// 16 values in at least 200 bytes.
inline constexpr std::size_t kMostRecordingValues = 131'072;

/// Reads a recording (docs/contracts.md, "Recorded interaction") from a request and reports errors.
/// The stored form contains no personal data: names of materials and lights may be user input, and
/// textures are images, so both are removed.
Recording read_recording(Fields& in);

}  // namespace diaphane::api
