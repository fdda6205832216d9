#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/renderer/reference.h"

// Error against run time. Pictures of 1, 2, 4 ... samples are rendered from an empty film in one
// call each. Reports their time, their true error, and the error that the renderer estimates.

namespace diaphane::render::bench {

/// The results for one number of samples. Each repetition has its own seed.
struct CurvePoint {
  std::uint32_t samples = 0;
  double milliseconds = 0;         ///< median wall-clock time of render()
  double milliseconds_spread = 0;  ///< standard deviation
  double rmse = 0;                 ///< root mean square, with the reference's noise removed
  double rmse_spread = 0;
  double estimate = 0;           ///< root mean square of the estimates; infinity below two samples
  std::uint64_t dropped = 0;     ///< samples that were not finite, over all repetitions
  std::uint64_t non_finite = 0;  ///< non-finite values in the pictures
};

/// The point where a curve crosses an error, with straight lines between points in log-log space.
struct Crossing {
  double samples = 0;
  double milliseconds = 0;
  enum class How {
    kBetween,   ///< between two points
    kFirst,     ///< one sample is already below; the values are those of one sample
    kProlonged  ///< extrapolated with the slope of the last points, not measured
  } how = How::kBetween;
};

struct Curve {
  Method method;
  std::vector<std::string> features;
  std::string kernel;  ///< how it was chosen
  std::vector<CurvePoint> points;
  std::optional<std::string> left_out;  ///< why this method does not exist here
};

struct Convergence {
  Reference reference;
  std::vector<Curve> curves;
};

struct ConvergenceOptions {
  std::vector<Method> methods;
  std::uint32_t most = 256;  ///< maximum samples
  std::uint32_t repeats = 5;
  double warm_up = 0.5;  ///< seconds of rendering that are discarded first
  /// Error of the reference as a share of the smallest measured error.
  double reference_share = 0.1;
  double reference_seconds = 120;
  std::string cache;
  bool fresh = false;
  std::function<void(const std::string&)> say;  ///< reports progress
};

Result<Convergence> measure_convergence(const Subject& subject, const ConvergenceOptions& options);

/// Returns the least-squares slope of log(error) over log(samples) for points with at least `from`
/// samples and a finite positive error. Returns nullopt with fewer than three points.
std::optional<double> slope(const Curve& curve, double CurvePoint::*error, std::uint32_t from);

/// Returns where the curve's true error (or its estimate) reaches `error`. Returns nullopt if the
/// only point is above it, or if the curve does not fall.
std::optional<Crossing> crossing(const Curve& curve, double error,
                                 double CurvePoint::*of = &CurvePoint::rmse);

}  // namespace diaphane::render::bench
