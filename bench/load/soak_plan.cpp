#include "bench/load/soak_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace diaphane::api::load {
namespace {

struct Size {
  double width, height;
};
constexpr std::array<Size, 5> kSizes{{{160, 90}, {320, 320}, {512, 512}, {768, 432}, {1280, 720}}};
constexpr double kSmallestSide = 16;

std::uint32_t side(double length, double scale) {
  return static_cast<std::uint32_t>(std::lround(std::max(kSmallestSide, length * scale)));
}

}  // namespace

Visit draw_visit(std::mt19937_64& draws, double scale, double act_seconds) {
  const auto below = [&](std::uint64_t n) {
    return std::uniform_int_distribution<std::uint64_t>(0, n - 1)(draws);
  };
  const auto seconds = [&](double typical) {
    return std::uniform_real_distribution<double>(0.3 * typical, 1.7 * typical)(draws);
  };
  Visit visit;
  const Size size = kSizes[below(kSizes.size())];
  visit.width = side(size.width, scale);
  visit.height = side(size.height, scale);
  if (below(5) == 0) visit.read_pause_ms = static_cast<std::uint32_t>(50 + below(250));
  using Kind = Act::Kind;
  // Looking and dragging are the most frequent actions.
  constexpr std::array<Kind, 10> kKinds{Kind::kLook,   Kind::kLook, Kind::kDrag,   Kind::kDrag,
                                        Kind::kDrag,   Kind::kHide, Kind::kResize, Kind::kReload,
                                        Kind::kReload, Kind::kCut};
  for (std::uint64_t i = 2 + below(5); i > 0; --i) {
    visit.acts.push_back({kKinds[below(kKinds.size())], seconds(act_seconds)});
  }
  visit.ends_session = below(2) == 0;
  visit.pause = seconds(0.5 * act_seconds);
  return visit;
}

}  // namespace diaphane::api::load
