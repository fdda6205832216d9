#include "renderd/scene/file_order.h"

#include "renderd/film/canvas.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/video_path.h"
#include "scene/annotations.h"

namespace diaphane::render {

namespace v1 = diaphane::v1;

namespace {

std::uint64_t pixels_of(const v1::FileMark& mark) {
  return std::uint64_t{mark.label().width()} * mark.label().height();
}

bool is_scale(double scale) { return scale >= kLeastMarkUnit && scale <= kMostMarkUnit; }

bool is_valid(const v1::FileMark::Label& label) {
  const auto is_inside = [](double at, double side) { return at >= 0 && at <= side; };
  return label.width() > 0 && label.height() > 0 && label.width() <= kMostLabelPixels &&
         label.height() <= kMostLabelPixels && is_scale(label.scale()) &&
         is_inside(label.margin(), label.width() / 2.0) &&
         is_inside(label.baseline(), label.height());
}

}  // namespace

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

Result<void> note_file_mark(std::vector<v1::FileMark>& marks, const v1::FileMark& mark) {
  v1::Marks alone;
  *alone.add_items() = mark.mark();
  if (!scene::are_valid(alone) || (mark.has_label() && !is_valid(mark.label()))) {
    return fail(ErrorCode::kInvalid, "A mark is not valid.");
  }
  std::uint64_t pixels = pixels_of(mark);
  if (pixels > kMostLabelPixels) return fail(ErrorCode::kInvalid, "A mark's text is too large.");
  for (const v1::FileMark& one : marks) pixels += pixels_of(one);
  if (marks.size() >= kMostFileMarks) {
    return fail(ErrorCode::kInvalid, "A file can contain at most 100 marks.");
  }
  if (pixels > kMostPixelsOfLabels) {
    return fail(ErrorCode::kInvalid, "The texts of the marks in a file are too large.");
  }
  marks.push_back(mark);
  return {};
}

Result<void> check_mark_unit(const v1::FileRequest& request) {
  if (request.mark_unit() == 0 || is_scale(request.mark_unit())) return {};
  return fail(ErrorCode::kInvalid, "The size of the marks must be 0.1 to 100.", "mark_unit");
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
