#include "renderd/scene/file_order.h"

#include "renderd/film/canvas.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/video_path.h"

namespace diaphane::render {

namespace v1 = diaphane::v1;

Result<void> note_key_view(std::vector<v1::Scene>& keys, const v1::KeyView& view) {
  const bool first = view.index() == 0;  // begins a new list
  if ((!first && view.index() != keys.size()) || view.index() >= kMostKeyViews) {
    return fail(ErrorCode::kInvalid, "Views must be sent in order, at most 16.");
  }
  if (const auto sound = check_scene(view.scene()); !sound) return sound;
  if (first) keys.clear();
  keys.push_back(view.scene());
  return {};
}

Result<void> check_picture(const v1::LargePicture& picture, const std::vector<v1::Scene>& keys) {
  for (const std::uint32_t side : {picture.width(), picture.height()}) {
    if (side < kShortestFileSide || side > kLongestCanvas) {
      return fail(ErrorCode::kInvalid, "The image must be 16 to 16384 pixels wide and high.",
                  "width");
    }
  }
  if (!(picture.error() >= kLeastFileError && picture.error() <= 1)) {
    return fail(ErrorCode::kInvalid, "The error of the image must be between 0.005 and 1.",
                "error");
  }
  if (keys.empty()) return fail(ErrorCode::kInvalid, "The view is missing.", "keys");
  return check_scene(keys.front());
}

}  // namespace diaphane::render
