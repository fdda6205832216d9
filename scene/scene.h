#pragma once

#include <string>
#include <string_view>

#include "api/proto/scene.pb.h"
#include "common/result.h"

/// Validation and JSON form of scenes for files, presets and the stream, shared by api and renderd.
namespace diaphane::scene {

/// Returns whether the file of a texture can be shown. Its error names no field.
using PictureCheck = Result<void> (*)(std::string_view file);
/// A PictureCheck for callers that do not show textures.
Result<void> no_pictures(std::string_view file);

/// Checks all parts of a scene. Returns kInvalid with the first invalid field
/// ("lights[1].rectangle.radiance.r"), for example a number that is not finite, negative
/// extinction, a reversed or empty range, a missing channel, or a camera without direction.
Result<void> check_scene(const diaphane::v1::Scene& scene, PictureCheck check_picture);

/// Convert from and to the JSON form (Protobuf's mapping). Unknown fields are refused by name.
Result<diaphane::v1::Scene> scene_from_json(std::string_view json);
std::string scene_to_json(const diaphane::v1::Scene& scene);

}  // namespace diaphane::scene
