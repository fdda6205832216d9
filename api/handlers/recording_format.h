#pragma once

#include "api/handlers/request_fields.h"
#include "api/service/recordings.h"

namespace diaphane::api {

/// Of a request: one for each 8 bytes of the largest body (1 MB); 21 MB as a tree at most. What a
/// page records has fewer: it ends a recording at 500 KB, and a camera has 16 values in 200 bytes
/// or more.
inline constexpr std::size_t kMostRecordingValues = 131'072;

/// Reads a recording in the form of docs/contracts.md ("Recorded interaction") from a request and
/// notes what is wrong with it. What is kept of it says nothing of anybody: names of materials and
/// lights are text that a person may have typed, and textures are pictures; both are left out.
Recording read_recording(Fields& in);

}  // namespace diaphane::api
