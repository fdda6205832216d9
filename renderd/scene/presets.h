#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/scene/brain.h"
#include "renderd/scene/framing.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Returns the presets that a volume can show, fitted to it: of skin, muscle, vessels, bone,
/// through, dense and airways in a CT, and of brain, through, skin, muscle, vessels, bone and
/// airways otherwise. Where the brain is known, brain and through come first, and the airways,
/// which are guessed by brightness, are left out. The camera looks at the patient's face, or at the
/// brain, from above and from the patient's left, and the framed ellipsoid fits the picture. Lights
/// scale with it. Ranges are in Hounsfield units for CT and by
/// percentiles otherwise. A CT needs contrast agent for vessels (shows_contrast_agent()), teeth or
/// similar bone for dense, and air for airways; other scans need parts much brighter than tissue
/// for vessels. A change of a look must raise the version in api/scans/thumbnails.cpp.
std::vector<diaphane::v1::Preset> presets_for(const volume::Header& header, const Framing& framing,
                                              bool contrast_agent,
                                              const std::optional<BrainFacts>& brain = {});
/// Returns one preset, even if the volume can't show it well. Where no brain is known, the looks of
/// the brain are replaced by skin. Returns kNotFound for an unknown name.
Result<diaphane::v1::Preset> preset_for(const volume::Header& header, const Framing& framing,
                                        std::string_view name,
                                        const std::optional<BrainFacts>& brain = {});

/// Checks all fields of a scene. Fails with kInvalid and the name of the first wrong field
/// ("lights[1].rectangle.radiance.r") for numbers that are not finite, negative extinction,
/// reversed or empty ranges, no channel, or a camera without direction.
Result<void> check_scene(const diaphane::v1::Scene& scene);

/// Convert a scene from and to JSON. Unknown fields are refused by name.
Result<diaphane::v1::Scene> scene_from_json(std::string_view json);
std::string scene_to_json(const diaphane::v1::Scene& scene);

}  // namespace diaphane::render
