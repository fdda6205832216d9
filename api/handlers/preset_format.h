#pragma once

#include "api/handlers/message.h"
#include "api/handlers/request_fields.h"
#include "api/service/presets.h"

/// A preset as it comes and goes (docs/presets.md): JSON, and XML to be exchanged.
namespace diaphane::api {

inline constexpr int kPresetVersion = 1;
inline constexpr std::size_t kMostPresetBytes = 256 * 1024;  ///< of a request

/// kBodyTooLarge. Looked at when the body is here: a listener that refuses a body half way resets
/// the connection, and the edge may lose the answer.
Outcome<void> check_size(const Request& request);

/// Reads `scene` strictly and checks it as the stream does; what is wrong is noted by its path
/// ("scene.camera.eye.x"). Gives the JSON that is kept.
std::string read_scene(Fields& in);
/// `version` of the format, if it is there: a later one is refused.
void read_format_version(Fields& in);
/// Name, scene and, when the document holds more, the document. kInvalid, kMediaType.
Outcome<Preset> read_preset_xml(const Request& request);

/// The version that a change is based on. kPreconditionRequired without If-Match, kPrecondition for
/// what no version can match.
Outcome<int> version_in_if_match(const Request& request);
std::string etag_of(const Preset& preset);

/// Without the scene: lists.
nlohmann::ordered_json to_json(const Preset& preset);
nlohmann::ordered_json with_scene(const Preset& preset);
std::string to_xml(const Preset& preset);

/// The serialised message of a scene that is kept; empty when it cannot be read.
std::string scene_bytes(const std::string& scene);

}  // namespace diaphane::api
