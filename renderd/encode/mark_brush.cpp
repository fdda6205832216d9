#include "renderd/encode/mark_brush.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace diaphane::render {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
/// Side of a tile in pixels. Only tiles near a line are visited pixel by pixel.
constexpr std::uint32_t kTile = 16;

double distance(PicturePoint a, PicturePoint b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Returns how far `along` lies from the nearest dash of a line that is `length` long.
double beyond_dash(double along, double length, double dash) {
  if (dash <= 0) return along - std::clamp(along, 0.0, length);
  const double period = 2 * dash;
  double nearest = kFar;
  for (double k = std::floor(along / period) - 1; k <= std::floor(along / period) + 1; ++k) {
    const double begin = k * period;
    if (begin < 0 || begin >= length) continue;
    const double gap = along - std::clamp(along, begin, std::min(begin + dash, length));
    if (std::fabs(gap) < std::fabs(nearest)) nearest = gap;
  }
  return nearest;
}

double from_line(PicturePoint p, const std::array<PicturePoint, 2>& line, double dash) {
  const double length = distance(line[0], line[1]);
  if (length == 0) return distance(p, line[0]);
  const double x = (line[1].x - line[0].x) / length, y = (line[1].y - line[0].y) / length;
  const double along = (p.x - line[0].x) * x + (p.y - line[0].y) * y;
  const double aside = (p.y - line[0].y) * x - (p.x - line[0].x) * y;
  return std::hypot(beyond_dash(along, length, dash), aside);
}

double from_circle(PicturePoint p, const Disc& circle, double dash) {
  const double aside = distance(p, circle.at) - circle.radius;
  if (dash <= 0) return std::fabs(aside);
  double angle = std::atan2(p.y - circle.at.y, p.x - circle.at.x);
  if (angle < 0) angle += 2 * std::numbers::pi;
  const double length = 2 * std::numbers::pi * circle.radius;
  // The first dash begins where the last one ends.
  const double gap = std::min(std::fabs(beyond_dash(angle * circle.radius, length, dash)),
                              std::fabs(beyond_dash(angle * circle.radius - length, length, dash)));
  return std::hypot(gap, aside);
}

/// Returns the distance from the edge of a triangle. Negative inside.
double from_triangle(PicturePoint p, const std::array<PicturePoint, 3>& corners) {
  double edge = kFar;
  bool left = true, right = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const PicturePoint a = corners[i], b = corners[(i + 1) % 3];
    edge = std::min(edge, from_line(p, {a, b}, 0));
    const double side = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    left = left && side >= 0;
    right = right && side <= 0;
  }
  return left || right ? -edge : edge;
}

/// Returns the distance from the edge of what the pen draws. Negative inside.
double from_ink(PicturePoint p, const MarkLines& lines, const Pen& pen) {
  const double half = pen.width / 2;
  double nearest = kFar;
  for (const auto& line : lines.lines) {
    nearest = std::min(nearest, from_line(p, line, pen.dash) - half);
  }
  if (lines.circle) nearest = std::min(nearest, from_circle(p, *lines.circle, pen.dash) - half);
  if (lines.head) nearest = std::min(nearest, from_triangle(p, *lines.head) - half);
  for (const auto& dot : lines.dots) nearest = std::min(nearest, distance(p, dot) - pen.width);
  return nearest;
}

void blend(std::uint8_t* pixel, MarkColour colour, double opacity) {
  const std::array<std::uint8_t, 3> channels{colour.r, colour.g, colour.b};
  for (std::size_t i = 0; i < 3; ++i) {
    const double mixed = pixel[i] + (channels.at(i) - double(pixel[i])) * opacity;
    pixel[i] = static_cast<std::uint8_t>(std::lround(mixed));
  }
}

std::uint8_t* pixel_of(PictureRgb8& picture, std::uint32_t x, std::uint32_t y) {
  return &picture.pixels[3 * (std::size_t{picture.size.width} * y + x)];
}

/// Returns the centre of a pixel in the whole picture.
PicturePoint centre_of(const PictureRgb8& picture, std::uint32_t x, std::uint32_t y) {
  return {x + 0.5, picture.size.first_row + y + 0.5};
}

/// Returns the bilinearly interpolated coverage of a stamp, which is 0 outside.
double coverage_at(const Stamp& stamp, double x, double y) {
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const auto at = [&](double column, double row) {
    if (column < 0 || row < 0 || column >= stamp.width || row >= stamp.height) return 0.0;
    const auto index = static_cast<std::size_t>(row) * stamp.width;
    return stamp.coverage[index + static_cast<std::size_t>(column)] / 255.0;
  };
  const double u = x - 0.5 - left, v = y - 0.5 - top;
  return (at(left, top) * (1 - u) + at(left + 1, top) * u) * (1 - v) +
         (at(left, top + 1) * (1 - u) + at(left + 1, top + 1) * u) * v;
}

/// Returns the range of pixels that a span of the picture touches.
std::array<std::uint32_t, 2> touched(double begin, double end, std::uint32_t size) {
  const auto side = [size](double at) {
    return static_cast<std::uint32_t>(std::clamp(at, 0.0, double(size)));
  };
  return {side(std::floor(begin)), side(std::ceil(end))};
}

}  // namespace

void draw(PictureRgb8& picture, const MarkLines& lines, const Pen& pen) {
  const auto [width, height, first, whole] = picture.size;
  for (std::uint32_t top = 0; top < height; top += kTile) {
    for (std::uint32_t left = 0; left < width; left += kTile) {
      // A dashed line is at least as far away as the same line without gaps.
      const PicturePoint middle{left + kTile / 2.0, first + top + kTile / 2.0};
      if (from_ink(middle, lines, {{}, pen.width, 0, 1}) > kTile) continue;
      for (std::uint32_t y = top; y < std::min(top + kTile, height); ++y) {
        for (std::uint32_t x = left; x < std::min(left + kTile, width); ++x) {
          const double edge = from_ink(centre_of(picture, x, y), lines, pen);
          const double coverage = std::clamp(0.5 - edge, 0.0, 1.0);
          if (coverage > 0) blend(pixel_of(picture, x, y), pen.colour, coverage * pen.opacity);
        }
      }
    }
  }
}

void draw(PictureRgb8& picture, const Stamp& stamp, MarkColour colour, double opacity) {
  const double top = stamp.at.y - picture.size.first_row;
  const auto columns =
      touched(stamp.at.x, stamp.at.x + stamp.width * stamp.scale, picture.size.width);
  const auto rows = touched(top, top + stamp.height * stamp.scale, picture.size.height);
  for (std::uint32_t y = rows[0]; y < rows[1]; ++y) {
    for (std::uint32_t x = columns[0]; x < columns[1]; ++x) {
      const PicturePoint p = centre_of(picture, x, y);
      const double coverage =
          coverage_at(stamp, (p.x - stamp.at.x) / stamp.scale, (p.y - stamp.at.y) / stamp.scale);
      if (coverage > 0) blend(pixel_of(picture, x, y), colour, coverage * opacity);
    }
  }
}

}  // namespace diaphane::render
