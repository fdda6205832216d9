#include "api/routing/annotation_fields.h"

#include "scene/annotations.h"

namespace diaphane::api {
namespace {

/// The limit of annotations.content and presets.annotations (migrations/0022).
constexpr std::size_t kMostAnnotationBytes = 131'072;

}  // namespace

std::string read_annotations(Fields& in, const std::string& field) {
  const nlohmann::json& given = in.any(field);
  if (!given.is_object()) {
    in.wrong(field, "must be an object");
    return {};
  }
  const auto read = scene::annotations_from_json(given.dump());
  if (!read) {
    in.wrong(field, read.error().message);
    return {};
  }
  std::string kept = scene::annotations_to_json(*read);
  if (kept.size() > kMostAnnotationBytes) in.wrong(field, "is too large (128 KB at most)");
  return kept;
}

}  // namespace diaphane::api
