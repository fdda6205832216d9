#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::render {

/// The presets (skin, muscle, vessels, bone, airways) fitted to a volume: camera in front of the
/// patient, at a distance from which the whole box is seen; lights by the box's radius; ranges in
/// Hounsfield units for CT, by percentiles otherwise.
std::vector<diaphane::v1::Preset> presets_for(const volume::Header& header);
Result<diaphane::v1::Preset> preset_for(const volume::Header& header, std::string_view name);

/// Checks everything that a scene may hold; the first thing wrong is named
/// ("lights[1].rectangle.radiance.r"). Not finite, negative extinction, reversed or empty ranges,
/// no channel, a camera without direction: kInvalid.
Result<void> check_scene(const diaphane::v1::Scene& scene);

/// The JSON form, both ways. Unknown fields are refused by name.
Result<diaphane::v1::Scene> scene_from_json(std::string_view json);
std::string scene_to_json(const diaphane::v1::Scene& scene);

}  // namespace diaphane::render
