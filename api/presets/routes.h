#pragma once

#include <vector>

#include "api/presets/preset_pictures.h"
#include "api/presets/presets.h"
#include "api/presets/recordings.h"
#include "api/routing/request_router.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> preset_routes(Presets& presets, PresetPictures& pictures);
std::vector<Route> recording_routes(Recordings& recordings);

}  // namespace diaphane::api
