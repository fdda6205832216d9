#include "bench/renderer/convergence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "bench/renderer/timing.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

/// One picture from an empty film.
struct Shot {
  double milliseconds = 0;
  double estimate = 0;
  double rmse = 0;  ///< includes the reference's noise
  std::uint64_t dropped = 0;
  std::uint64_t non_finite = 0;
};

double root_mean_square(const std::vector<double>& values) {
  double squared = 0;
  for (const double x : values) squared += x * x;
  return std::sqrt(squared / static_cast<double>(values.size()));
}

/// Renders for `seconds`. On CUDA, also waits until the kernel for this scene has been compiled.
/// Until then, a general kernel is used; the compiled one is used from the next picture. If kernels
/// are chosen in another way, none is compiled, and the wait ends after 15 s.
Result<void> warm_up(ProgressiveRenderer& renderer, const Subject& subject, double seconds) {
  constexpr double kLongestCompilation = 15;
  const bool compiles = subject.engine->info().engine == "cuda" && seconds > 0;
  const auto begin = Clock::now();
  const auto compiling = [&] {
    const KernelReport report = renderer.report();
    return compiles && report.origin != KernelOrigin::kForThisScene && report.note.empty() &&
           seconds_since(begin) < kLongestCompilation;
  };
  do {
    if (auto set = renderer.set_scene(subject.scene, subject.canvas); !set) return set;
    if (auto batch = renderer.render(1, [] { return false; }); !batch) {
      return tl::unexpected(batch.error());
    }
  } while (seconds_since(begin) < seconds || compiling());
  return {};
}

Result<std::unique_ptr<FrameRenderer>> renderer_of(const Subject& subject, std::uint64_t seed,
                                                   Method method) {
  auto renderer = subject.engine->renderer(subject.volume, seed, 0, method);
  if (!renderer) return renderer;
  DIAPHANE_TRY((*renderer)->set_scene(subject.scene, subject.canvas));
  return renderer;
}

/// Returns the smallest error that a method will reach, by its own estimate.
Result<double> smallest_error(const Subject& subject, const ConvergenceOptions& options,
                              Method method) {
  auto renderer = renderer_of(subject, 0, method);
  DIAPHANE_TRY(renderer);
  auto batch = (*renderer)->render(std::max(options.most, 2u), [] { return false; });
  DIAPHANE_TRY(batch);
  return (*renderer)->progress().error;
}

Result<Shot> shoot(FrameRenderer& renderer, const Subject& subject, std::uint32_t samples,
                   const Reference& reference) {
  DIAPHANE_TRY(renderer.set_scene(subject.scene, subject.canvas));
  Shot shot;
  const auto begin = Clock::now();
  auto batch = renderer.render(samples, [] { return false; });
  shot.milliseconds = seconds_since(begin) * 1e3;
  DIAPHANE_TRY(batch);
  shot.dropped = batch->dropped_samples;
  shot.estimate = renderer.progress().error;
  PictureRgbF picture;
  DIAPHANE_TRY(renderer.radiance(picture));
  const PictureError error = error_against(reference, picture);
  shot.rmse = error.rmse;
  shot.non_finite = error.non_finite;
  return shot;
}

CurvePoint summarise(std::uint32_t samples, const std::vector<Shot>& shots,
                     const Reference& reference) {
  CurvePoint point;
  point.samples = samples;
  std::vector<double> milliseconds, rmse, estimate;
  for (const Shot& shot : shots) {
    milliseconds.push_back(shot.milliseconds);
    rmse.push_back(shot.rmse);
    estimate.push_back(shot.estimate);
    point.dropped += shot.dropped;
    point.non_finite += shot.non_finite;
  }
  point.milliseconds = median_of(milliseconds);
  point.milliseconds_spread = deviation_of(milliseconds);
  point.rmse = without_noise_of(reference, root_mean_square(rmse));
  point.rmse_spread = deviation_of(rmse);
  point.estimate = root_mean_square(estimate);
  return point;
}

/// Measures a curve repetition by repetition, so that disturbances on the machine affect all
/// numbers of samples equally.
Result<void> measure(const Subject& subject, const ConvergenceOptions& options,
                     const Reference& reference, Curve& curve) {
  std::vector<std::vector<Shot>> shots;
  for (std::uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
    auto renderer = renderer_of(subject, 1 + repeat, curve.method);
    DIAPHANE_TRY(renderer);
    if (auto warm = warm_up(**renderer, subject, repeat == 0 ? options.warm_up : 0); !warm)
      return warm;
    std::size_t power = 0;
    for (std::uint32_t n = 1; n <= options.most; n *= 2, ++power) {
      auto shot = shoot(**renderer, subject, n, reference);
      DIAPHANE_TRY(shot);
      if (repeat == 0) shots.emplace_back();
      shots[power].push_back(*shot);
    }
    curve.features = (*renderer)->features();
    curve.kernel = name_of((*renderer)->report().origin);
  }
  for (std::size_t power = 0; power < shots.size(); ++power) {
    curve.points.push_back(summarise(1u << power, shots[power], reference));
  }
  return {};
}

std::string in_words(const char* form, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, form, a, b);
  return text;
}

bool usable(double error) { return std::isfinite(error) && error > 0; }

}  // namespace

Result<Convergence> measure_convergence(const Subject& subject, const ConvergenceOptions& options) {
  const auto say = [&](const std::string& words) {
    if (options.say) options.say(words);
  };
  Convergence result;
  // The required quality of the reference follows from the smallest error that it must judge.
  double smallest = std::numeric_limits<double>::infinity();
  for (const Method& method : options.methods) {
    Curve curve{method, {}, {}, {}, {}};
    const auto error = smallest_error(subject, options, method);
    if (error) {
      if (usable(*error)) smallest = std::min(smallest, *error);
    } else if (error.error().code == ErrorCode::kUnsupported) {
      curve.left_out = error.error().message;
    } else {
      return tl::unexpected(error.error());
    }
    result.curves.push_back(std::move(curve));
  }
  // Infinity if there is nothing to judge, so that the first piece suffices.
  const double wanted = options.reference_share * smallest;
  say(in_words("smallest estimated error %.3g: reference to %.3g", smallest, wanted));
  auto reference = reference_of(
      subject,
      {wanted, options.reference_seconds, options.cache, options.fresh, [&](const Reference& r) {
         say(in_words("reference: %.0f samples, its own error %.3g", r.samples, r.error));
       }});
  DIAPHANE_TRY(reference);
  result.reference = *std::move(reference);
  for (Curve& curve : result.curves) {
    if (curve.left_out) continue;
    DIAPHANE_TRY(measure(subject, options, result.reference, curve));
  }
  return result;
}

std::optional<double> slope(const Curve& curve, double CurvePoint::*error, std::uint32_t from) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const CurvePoint& point : curve.points) {
    if (point.samples < from || !usable(point.*error)) continue;
    const double a = std::log(point.samples), b = std::log(point.*error);
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  if (n < 3) return std::nullopt;
  return (n * xy - x * y) / (n * xx - x * x);
}

std::optional<Crossing> crossing(const Curve& curve, double error, double CurvePoint::*of) {
  std::vector<CurvePoint> points;
  for (const CurvePoint& point : curve.points) {
    if (usable(point.*of)) points.push_back(point);
  }
  if (points.empty()) return std::nullopt;
  if (points[0].*of <= error) {
    return Crossing{double{1} * points[0].samples, points[0].milliseconds, Crossing::How::kFirst};
  }
  if (points.size() < 2) return std::nullopt;
  std::size_t above = 0;
  while (above + 2 < points.size() && points[above + 1].*of > error) ++above;
  const CurvePoint &a = points[above], &b = points[above + 1];
  const double t = std::log(a.*of / error) / std::log(a.*of / b.*of);
  if (!(t >= 0) || !std::isfinite(t)) return std::nullopt;  // the error does not fall
  const auto between = [t](double from, double to) { return from * std::pow(to / from, t); };
  return Crossing{between(a.samples, b.samples), between(a.milliseconds, b.milliseconds),
                  t > 1 ? Crossing::How::kProlonged : Crossing::How::kBetween};
}

}  // namespace diaphane::render::bench
