#include <google/protobuf/util/json_util.h>

#include "scene/scene.h"

namespace diaphane::scene {
namespace {

/// Extracts the path and name of a field from Protobuf's messages, such as `(camera) spede: Cannot
/// find field.` or `(camera): ...`.
std::string field_in(const std::string& message) {
  const std::size_t end = message.find(": Cannot find field");
  if (end == std::string::npos) return {};
  std::string path;
  const std::size_t open = message.find('(');
  const std::size_t close = message.find(')');
  if (open != std::string::npos && close != std::string::npos && open < close && close < end) {
    path = message.substr(open + 1, close - open - 1);
  }
  const std::size_t space = message.find_last_of(" :", end - 1);
  const std::size_t begin = space == std::string::npos ? 0 : space + 1;
  const std::string name = message.substr(begin, end - begin);
  return path.empty() ? name : path + "." + name;
}

}  // namespace

Result<diaphane::v1::Scene> scene_from_json(std::string_view json) {
  diaphane::v1::Scene scene;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = false;
  const auto status = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), &scene, options);
  if (!status.ok()) {
    const std::string text(status.message());
    const std::string field = field_in(text);
    if (!field.empty()) return fail(ErrorCode::kInvalid, "unknown field " + field, field);
    return fail(ErrorCode::kInvalid, "the scene is not valid: " + text);
  }
  return scene;
}

std::string scene_to_json(const diaphane::v1::Scene& scene) {
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  // Serialising a valid message to a string cannot fail.
  (void)google::protobuf::util::MessageToJsonString(scene, &json, options);
  return json;
}

}  // namespace diaphane::scene
