#include "renderd/session/quality.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace diaphane::render {
namespace {

// As in schedule/canvas.cpp: the number of pixels falls by about half per step.
constexpr std::array<double, 7> kScales{1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125};
constexpr double kFramesPerSecond = 24;  // minimum frame rate of a moving picture
constexpr double kUse = 0.85;            // usable share of the capacity; the rest drains the queue
// Seconds for which a settled frame may fill the link, which delays the answer to a new input.
constexpr double kSettledSeconds = 0.3;
constexpr double kSlackSeconds = 0.04;  // seconds of data in transit beyond a round trip
constexpr double kMargin = 1.3;         // margin by which a better step must fit
constexpr double kBetterAfterSeconds = 1;
constexpr double kFewestBytes = 1500;  // minimum bytes per frame: one packet
constexpr std::uint64_t kMostFrames = 12;
constexpr double kMostBytes = 8 << 20;

// Bits per pixel at which a moving picture still looks good. These are guesses that have not been
// verified with pictures.
double bits_per_pixel(v1::Codec codec) {
  switch (codec) {
    case v1::H264:
      return 0.1;
    case v1::MPEG1:
      return 0.3;
    default:
      return 0.8;
  }
}

}  // namespace

const QualityPlan& QualitySteps::update(const LinkEstimate& link, Canvas viewport, v1::Codec codec,
                                        Time now) {
  if (!link.known()) return plan_;
  const double rate = link.bytes_per_second(now);
  const double usable = kUse * rate;
  const auto needs = [&](std::size_t step) {
    const double pixels = kScales[step] * kScales[step] * viewport.width * viewport.height;
    return pixels * bits_per_pixel(codec) / 8 * kFramesPerSecond;
  };
  const std::size_t before = step_;
  while (step_ + 1 < kScales.size() && needs(step_) > usable) ++step_;
  const bool better = step_ == before && step_ > 0 && usable > kMargin * needs(step_ - 1);
  if (!better) {
    fits_since_ = {};
  } else if (fits_since_ == Time{}) {
    fits_since_ = now;
  } else if (std::chrono::duration<double>(now - fits_since_).count() >= kBetterAfterSeconds) {
    --step_;
    fits_since_ = {};
  }

  const auto bytes = [](double requested) {
    return static_cast<std::uint32_t>(std::clamp(requested, kFewestBytes, kMostBytes));
  };
  plan_.moving_scale = kScales[step_];
  plan_.moving_bytes = bytes(usable / kFramesPerSecond);
  plan_.settled_bytes = bytes(usable * kSettledSeconds);
  plan_.window_bytes = bytes(rate * (link.round_trip() + kSlackSeconds));
  const double frames = 2 + link.round_trip() * kFramesPerSecond;
  plan_.window_frames = std::min(kMostFrames, static_cast<std::uint64_t>(frames));
  return plan_;
}

}  // namespace diaphane::render
