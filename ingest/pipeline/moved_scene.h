#pragma once

#include <string>

#include "common/result.h"
#include "volume/region.h"

namespace diaphane::ingest {

/// Returns a scene (Protobuf JSON) after the origin of its world moved, so that a point at p is at
/// p - shift. Camera, clip, slices and lights move along, and everything locked to the camera
/// stays. Returns kInvalid if the text is not a scene.
Result<std::string> moved_scene(const std::string& scene, const volume::Vector& shift);

/// Returns the tour of a scan (JSON) after the same move. Returns kInvalid if the text is not a
/// tour.
Result<std::string> moved_tour(const std::string& tour, const volume::Vector& shift);

}  // namespace diaphane::ingest
