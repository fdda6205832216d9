#include "renderd/encode/file_marks.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/try.h"
#include "renderd/scene/camera.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

/// The colours of style/picture.css.
constexpr std::array<MarkColour, 8> kColours{{{0xff, 0xb4, 0x54},
                                              {0x6e, 0xcb, 0xff},
                                              {0xf5, 0x9a, 0xc8},
                                              {0x8f, 0xe0, 0x8a},
                                              {0xf6, 0xe0, 0x5e},
                                              {0xc3, 0xa6, 0xff},
                                              {0x63, 0xe0, 0xcf},
                                              {0xff, 0x94, 0x80}}};
constexpr MarkColour kDark{0x14, 0x18, 0x1d};
// Sizes in pixels of the page.
constexpr double kShortestArrow = 14, kLeastRadius = 3;
/// Width of the space that a text may need, for the choice of a side.
constexpr double kTextWidth = 130;

/// Projects places to the whole picture.
class Projection {
 public:
  Projection(const v1::Camera& camera, Canvas canvas)
      : axes_(camera),
        eye_(vector_of(camera.eye())),
        width_(canvas.width),
        height_(canvas.picture_height()),
        parallel_mm_(camera.orthographic_height()),
        spread_(2 * std::tan(camera.vertical_fov_degrees() * std::numbers::pi / 360)) {}

  /// Returns the position in pixels, or nullopt for a place behind the eye.
  std::optional<PicturePoint> point(Double3 place) const {
    const Double3 from_eye = place - eye_;
    const double ahead = -dot(from_eye, axes_.back);
    if (ahead < 1) return std::nullopt;
    const double pixels = height_ / (parallel_mm_ > 0 ? parallel_mm_ : spread_ * ahead);
    const PicturePoint at{width_ / 2 + dot(from_eye, axes_.right) * pixels,
                          height_ / 2 - dot(from_eye, axes_.up) * pixels};
    if (!std::isfinite(at.x + at.y)) return std::nullopt;  // a tiny angle of view
    return at;
  }
  /// Returns the radius in pixels at which a sphere appears.
  double radius(Double3 place, double mm) const {
    const auto middle = point(place), edge = point(place + axes_.right * mm);
    return middle && edge ? std::hypot(edge->x - middle->x, edge->y - middle->y) : 0;
  }
  double width() const { return width_; }

 private:
  const CameraAxes axes_;
  const Double3 eye_;
  const double width_, height_;
  const double parallel_mm_, spread_;
};

enum class Anchor { kStart, kMiddle, kEnd };

struct Shapes {
  MarkLines lines;
  PicturePoint text;
  Anchor anchor = Anchor::kStart;
};

Shapes arrow(const v1::Mark& mark, const Projection& projection, PicturePoint at, double unit) {
  const PicturePoint tail = projection.point(vector_of(mark.tail())).value_or(at);
  const double size = std::hypot(tail.x - at.x, tail.y - at.y);
  // An arrow that points straight away from the viewer would have no direction.
  const double x = size > 1 ? (tail.x - at.x) / size : -0.7;
  const double y = size > 1 ? (tail.y - at.y) / size : -0.7;
  const double longest = std::max(size, kShortestArrow * unit);
  const PicturePoint end{at.x + x * longest, at.y + y * longest};
  const auto along = [&](double ahead, double side) {
    return PicturePoint{at.x + unit * (x * ahead - y * side), at.y + unit * (y * ahead + x * side)};
  };
  const bool right = end.x >= at.x;
  const bool fits =
      right ? end.x + kTextWidth * unit < projection.width() : end.x > kTextWidth * unit;
  Shapes shapes;
  shapes.lines.lines = {{end, along(8, 0)}};
  shapes.lines.head = {at, along(13, 5.5), along(13, -5.5)};
  shapes.anchor = right == fits ? Anchor::kStart : Anchor::kEnd;
  shapes.text = {end.x + (shapes.anchor == Anchor::kStart ? 6 : -6) * unit,
                 end.y + (fits ? 4 : -8) * unit};
  return shapes;
}

Shapes circle(const v1::Mark& mark, const Projection& projection, PicturePoint at, double unit) {
  const double radius =
      std::max(kLeastRadius * unit, projection.radius(vector_of(mark.place()), mark.radius()));
  const double above = at.y - radius - 8 * unit;
  Shapes shapes;
  shapes.lines.circle = {at, radius};
  shapes.text = {at.x, above > 16 * unit ? above : at.y + radius + 18 * unit};
  shapes.anchor = Anchor::kMiddle;
  return shapes;
}

Shapes text(const Projection& projection, PicturePoint at, double unit) {
  const bool right = at.x + kTextWidth * unit < projection.width();
  Shapes shapes;
  shapes.lines.dots = {at};
  shapes.text = {at.x + (right ? 10 : -10) * unit, at.y + 5 * unit};
  shapes.anchor = right ? Anchor::kStart : Anchor::kEnd;
  return shapes;
}

/// A ruler or an angle: lines from its point to the others, and its value beside the last dot, or
/// beside the vertex of an angle.
Shapes measurement(const v1::Mark& mark, const Projection& projection, PicturePoint at,
                   double unit) {
  const bool is_angle = mark.kind() == v1::Mark::ANGLE;
  const PicturePoint tail = projection.point(vector_of(mark.tail())).value_or(at);
  Shapes shapes = text(projection, is_angle ? at : tail, unit);
  shapes.lines.dots = {at, tail};
  shapes.lines.lines = {{at, tail}};
  if (is_angle) {
    const PicturePoint end = projection.point(vector_of(mark.end())).value_or(at);
    shapes.lines.dots.push_back(end);
    shapes.lines.lines.push_back({at, end});
  }
  return shapes;
}

std::optional<Shapes> shapes_of(const v1::Mark& mark, const Projection& projection, double unit) {
  const auto at = projection.point(vector_of(mark.place()));
  if (!at) return std::nullopt;
  if (mark.kind() == v1::Mark::ARROW) return arrow(mark, projection, *at, unit);
  if (mark.kind() == v1::Mark::CIRCLE) return circle(mark, projection, *at, unit);
  if (mark.kind() == v1::Mark::RULER || mark.kind() == v1::Mark::ANGLE) {
    return measurement(mark, projection, *at, unit);
  }
  return text(projection, *at, unit);
}

/// Returns where the text begins on its baseline.
PicturePoint start_of_text(const Shapes& shapes, const v1::FileMark::Label& label) {
  const double width = (label.width() - 2 * label.margin()) * label.scale();
  const double share = shapes.anchor == Anchor::kStart    ? 0
                       : shapes.anchor == Anchor::kMiddle ? 0.5
                                                          : 1;
  return {shapes.text.x - share * width, shapes.text.y};
}

}  // namespace

Result<FileMarks> FileMarks::make(std::vector<v1::FileMark> marks, double unit,
                                  FindHidden find_hidden) {
  FileMarks made;
  for (v1::FileMark& mark : marks) {
    const std::size_t pixels = std::size_t{mark.label().width()} * mark.label().height();
    std::string both(2 * pixels, '\0');
    std::string& coded = *mark.mutable_label()->mutable_coverage();
    uLongf length = both.size();
    if (pixels > 0 &&
        (uncompress(reinterpret_cast<Bytef*>(both.data()), &length,
                    reinterpret_cast<const Bytef*>(coded.data()), coded.size()) != Z_OK ||
         length != both.size())) {
      return fail(ErrorCode::kInvalid, "The text of a mark is damaged.", "marks");
    }
    std::string().swap(coded);
    made.labels_.push_back({both.substr(0, pixels), both.substr(pixels)});
    made.places_.push_back(vector_of(mark.mark().place()));
  }
  made.marks_ = std::move(marks);
  made.unit_ = unit > 0 ? unit : 1;
  made.find_hidden_ = std::move(find_hidden);
  return made;
}

void FileMarks::draw(PictureRgb8& picture, const v1::Scene& scene) const {
  const Canvas whole{picture.size.width, picture.size.picture_height()};
  const std::vector<bool> hidden = find_hidden_(scene, whole, places_);
  const Projection projection(scene.camera(), whole);
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const auto shapes = shapes_of(marks_[i].mark(), projection, unit_);
    if (!shapes) continue;
    const double opacity = hidden[i] ? 0.5 : 1;
    const MarkColour colour = kColours.at(marks_[i].mark().colour());
    render::draw(picture, shapes->lines, {kDark, 5.5 * unit_, 0, opacity});
    render::draw(picture, shapes->lines, {colour, 2.5 * unit_, hidden[i] ? 5 * unit_ : 0, opacity});
    if (!labels_[i].letters.empty()) {
      draw_label(picture, i, start_of_text(*shapes, marks_[i].label()), opacity);
    }
  }
}

void FileMarks::draw_label(PictureRgb8& picture, std::size_t index, PicturePoint start,
                           double opacity) const {
  const v1::FileMark::Label& label = marks_[index].label();
  Stamp stamp{label.width(), label.height(), nullptr, start, label.scale()};
  stamp.at.x -= label.margin() * label.scale();
  stamp.at.y -= label.baseline() * label.scale();
  const auto print = [&](const std::string& coverage, MarkColour colour) {
    stamp.coverage = reinterpret_cast<const std::uint8_t*>(coverage.data());
    render::draw(picture, stamp, colour, opacity);
  };
  print(labels_[index].outline, kDark);
  print(labels_[index].letters, kColours.at(marks_[index].mark().colour()));
}

}  // namespace diaphane::render
