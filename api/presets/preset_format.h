#pragma once

#include "api/presets/presets.h"
#include "api/routing/message.h"
#include "api/routing/request_fields.h"

/// Serialisation of presets (docs/presets.md): JSON, and XML for exchange.
namespace diaphane::api {

inline constexpr int kPresetVersion = 1;
inline constexpr std::size_t kMostPresetBytes = 256 * 1024;  ///< maximum size of a request

/// Returns kBodyTooLarge above kMostPresetBytes. This is checked after the body was received:
/// refusing it halfway resets the connection, and the edge may lose the response.
Outcome<void> check_size(const Request& request);

/// Parses `scene` strictly and validates it like the stream does. Reports errors with their path
/// ("scene.camera.eye.x"). Returns the JSON to store.
std::string read_scene(Fields& in);
/// The same for a value that is not a field of its own. The error's `field` is the path in the scene.
Result<std::string> kept_scene(const nlohmann::json& given);
/// Checks the optional field `version` of the format. Refuses a newer one.
void read_format_version(Fields& in);
/// Parses and validates an XML document. Fills name, scene, annotations and kept_xml.
Outcome<Preset> read_preset_xml(const Request& request);

/// Returns the version that a change is based on. Returns kPreconditionRequired without If-Match
/// and kPrecondition for a value that cannot match any version.
Outcome<int> version_in_if_match(const Request& request);
std::string etag_of(const Preset& preset);

/// Converts a preset to JSON for lists, which omits the scene and the marks.
nlohmann::ordered_json to_json(const Preset& preset);
nlohmann::ordered_json with_scene(const Preset& preset);
std::string to_xml(const Preset& preset);

/// Serialises a stored scene, or returns an empty string if it cannot be parsed.
std::string scene_bytes(const std::string& scene);

}  // namespace diaphane::api
