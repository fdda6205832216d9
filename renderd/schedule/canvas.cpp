#include "renderd/schedule/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace diaphane::render {
namespace {

// Steps of about sqrt(2), so that each step roughly halves the number of pixels.
constexpr std::array<double, 7> kScales{1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125};

std::uint32_t scaled(std::uint32_t length, double scale) {
  if (scale >= 1.0) return length;
  // Sides are even because chroma is subsampled by two.
  const auto even = static_cast<std::uint32_t>(std::lround(length * scale / 2.0)) * 2;
  return std::min(length, std::max<std::uint32_t>(even, 16));
}

Canvas scaled(Canvas canvas, double scale) {
  return {scaled(canvas.width, scale), scaled(canvas.height, scale)};
}

}  // namespace

Canvas plan_canvas(const CanvasInput& input) {
  if (!input.moving) return input.viewport;
  const double cost = input.seconds_per_pixel;
  const double alone = cost > 0 ? kMovingSampleSeconds / cost : kProbePixels;
  // Returns the largest scale with at most `budget` pixels. The current size may exceed the budget
  // by a quarter, which avoids flicker.
  const auto largest = [&](double budget, double smallest) {
    for (const double scale : kScales) {
      const Canvas candidate = scaled(input.viewport, scale);
      const bool is_current = candidate == input.current;
      if (scale <= smallest || candidate.pixels() <= (is_current ? 1.25 * budget : budget)) {
        return scale;
      }
    }
    return kScales.back();
  };
  const double scale =
      std::min(largest(alone, kScales.back()), std::max(input.largest_moving, kScales.back()));
  if (input.sharing <= 1 || !(cost > 0)) return scaled(input.viewport, scale);
  const auto seconds = [&](double at) {
    return input.seconds_first + cost * scaled(input.viewport, at).pixels();
  };
  const double share =
      std::max(kSharedSeconds, seconds(scale)) / static_cast<double>(input.sharing);
  const double shared = largest((share - input.seconds_first) / cost, kSmallestShare * scale);
  return scaled(input.viewport, std::min(scale, shared));
}

}  // namespace diaphane::render
