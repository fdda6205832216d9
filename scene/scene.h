#pragma once

#include <string>
#include <string_view>

#include "api/proto/scene.pb.h"
#include "common/result.h"

/// What a scene may be and how it is written: the same for files, presets and the stream, for api
/// and renderd.
namespace diaphane::scene {

/// Says whether the file of a texture is one that will be shown; its error names no field.
using PictureCheck = Result<void> (*)(std::string_view file);
/// For who shows no textures.
Result<void> no_pictures(std::string_view file);

/// Checks everything that a scene may hold; the first thing wrong is named
/// ("lights[1].rectangle.radiance.r"). Not finite, negative extinction, reversed or empty ranges,
/// no channel, a camera without direction: kInvalid.
Result<void> check_scene(const diaphane::v1::Scene& scene, PictureCheck check_picture);

/// The JSON form (Protobuf's mapping), both ways. Unknown fields are refused by name.
Result<diaphane::v1::Scene> scene_from_json(std::string_view json);
std::string scene_to_json(const diaphane::v1::Scene& scene);

}  // namespace diaphane::scene
