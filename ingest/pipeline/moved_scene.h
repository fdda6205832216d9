#pragma once

#include <string>

#include "common/result.h"
#include "volume/region.h"

namespace diaphane::ingest {

/// A scene (its Protobuf JSON) after the origin of its world has moved: what was at p is at
/// p - shift. Camera, clip, slices and lights go along; what is locked to the camera stays.
/// kInvalid for what is no scene.
Result<std::string> moved_scene(const std::string& scene, const volume::Vector& shift);

}  // namespace diaphane::ingest
