#pragma once

#include "api/handlers/request_fields.h"
#include "api/service/recordings.h"

namespace diaphane::api {

/// Reads a recording in the form of docs/contracts.md ("Recorded interaction") from a request and
/// notes what is wrong with it. What is kept of it says nothing of anybody: names of materials and
/// lights are text that a person may have typed, and textures are pictures; both are left out.
Recording read_recording(Fields& in);

}  // namespace diaphane::api
