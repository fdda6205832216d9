#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/proto/scene.pb.h"
#include "api/proto/stream.pb.h"
#include "common/result.h"

/// The exchange format of presets (thesis 4.2: "a preset file, encoded in XML, which contains all
/// settings, e.g. transfer function, camera and light positions"). See docs/presets.md.
///
/// A message is an element with the JSON name of its field and a child for each field that is set.
/// A repeated field repeats its element. Numbers and names are text. The root is <preset
/// xmlns="urn:diaphane:preset" version="1" name="...">. Unknown elements and attributes are
/// preserved in place.
namespace diaphane::scene {

inline constexpr int kXmlVersion = 1;
inline constexpr std::size_t kMostXmlBytes = 256 * 1024;
inline constexpr int kDeepestXml = 32;
inline constexpr int kMostXmlNodes = 20'000;

struct XmlPreset {
  std::string name;
  diaphane::v1::Scene scene;  ///< parsed, but not checked (check_scene)
  /// The element <annotations>, parsed but not checked (check_annotations).
  std::optional<diaphane::v1::Annotations> annotations;
  /// The document has comments or unknown elements or attributes, so it is worth keeping.
  bool has_unknown = false;
};

/// Parses a preset. Returns kInvalid with the path of the element as the field
/// ("lights[1].rectangle.radiance.r"). The field is "preset" if the text is not XML, has a DTD, or
/// is too large or too deep, and "version" for a later version.
Result<XmlPreset> preset_from_xml(std::string_view xml);

/// Returns the XML of a preset. `kept` is the document from which it was read, or empty. Its
/// content besides the scene and the annotations is preserved. `annotations` is null if there are
/// none.
std::string preset_to_xml(std::string_view name, const diaphane::v1::Scene& scene,
                          std::string_view kept = {},
                          const diaphane::v1::Annotations* annotations = nullptr);

}  // namespace diaphane::scene
