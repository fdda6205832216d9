#include "renderd/session/convergence.h"

#include <chrono>
#include <cmath>
#include <utility>

namespace diaphane::render {
namespace {

constexpr double kGoodEnough = 0.05;

}  // namespace

Convergence::Measured Convergence::began(TimePoint input, TimePoint now) {
  Measured measured = ended();
  curve_.clear();
  input_ = input == TimePoint{} ? now : input;
  reached_ = false;
  return measured;
}

Convergence::Measured Convergence::progressed(const Progress& progress, bool moving,
                                              TimePoint now) {
  curve_.add({progress.samples, progress.seconds, progress.error});
  Measured measured;
  if (moving || !std::isfinite(progress.error)) return measured;
  rest_error_ = progress.error;
  if (reached_ || progress.error > kGoodEnough) return measured;
  reached_ = true;
  measured.seconds_to_five_percent = std::chrono::duration<double>(now - input_).count();
  return measured;
}

Convergence::Measured Convergence::ended() {
  Measured measured;
  measured.error_at_rest = std::exchange(rest_error_, std::nullopt);
  return measured;
}

v1::ErrorCurve to_proto(const ErrorCurve& curve, std::uint64_t epoch) {
  v1::ErrorCurve out;
  out.set_epoch(epoch);
  for (const ErrorPoint& point : curve.points()) {
    v1::ErrorCurve::Point& to = *out.add_points();
    to.set_samples(point.samples);
    to.set_seconds(point.seconds);
    to.set_error(point.error);
  }
  return out;
}

}  // namespace diaphane::render
