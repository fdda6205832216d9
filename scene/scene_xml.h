#pragma once

#include <string>
#include <string_view>

#include "api/proto/scene.pb.h"
#include "common/result.h"

/// The exchange format of presets (thesis 4.2: "a preset file, encoded in XML, which contains all
/// settings, e.g. transfer function, camera and light positions"), docs/presets.md.
///
/// A message is an element of its field's JSON name, with a child for each field that is set; a
/// repeated field repeats its element. Numbers and names are text. The root is
/// <preset xmlns="urn:diaphane:preset" version="1" name="...">. What is unknown here, elements and
/// attributes, is kept where it stands.
namespace diaphane::scene {

inline constexpr int kXmlVersion = 1;
inline constexpr std::size_t kMostXmlBytes = 256 * 1024;
inline constexpr int kDeepestXml = 32;
inline constexpr int kMostXmlNodes = 20'000;

struct XmlPreset {
  std::string name;
  diaphane::v1::Scene scene;  ///< read, not yet checked (check_scene)
  bool has_unknown = false;  ///< something in it is not of this version: worth keeping the document
};

/// kInvalid with the element's path as the field ("lights[1].rectangle.radiance.r"); for what is no
/// XML, has a DTD, is too large or too deep, "preset"; of a later version, "version".
Result<XmlPreset> preset_from_xml(std::string_view xml);

/// `kept`: the document that the preset was once read from, or empty; what it holds besides the
/// scene is kept.
std::string preset_to_xml(std::string_view name, const diaphane::v1::Scene& scene,
                          std::string_view kept = {});

}  // namespace diaphane::scene
