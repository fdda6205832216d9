#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "renderd/bench/reference.h"

// Error against run time: pictures of 1, 2, 4 ... samples, each rendered from an empty film in one
// call, their time, their true error and the error that the renderer itself estimates.

namespace diaphane::render::bench {

/// One number of samples; over the repetitions, each of which has a seed of its own.
struct CurvePoint {
  std::uint32_t samples = 0;
  double milliseconds = 0;         ///< median of render()'s wall clock
  double milliseconds_spread = 0;  ///< standard deviation
  double rmse = 0;                 ///< root mean square, without the reference's noise
  double rmse_spread = 0;
  double estimate = 0;           ///< root mean square of the estimates; infinity below two samples
  std::uint64_t dropped = 0;     ///< samples that were not finite, of all repetitions
  std::uint64_t non_finite = 0;  ///< numbers in the pictures
};

/// Where a curve crosses an error, straight lines between its points in log-log.
struct Crossing {
  double samples = 0;
  double milliseconds = 0;
  enum class How {
    kBetween,   ///< two points
    kFirst,     ///< one sample has less: what is given is for that one
    kProlonged  ///< the last points' slope goes on: not measured
  } how = How::kBetween;
};

struct Curve {
  Method method;
  std::vector<std::string> features;
  std::string kernel;  ///< where it came from
  std::vector<CurvePoint> points;
  std::optional<std::string> left_out;  ///< why this choice does not exist here
};

struct Convergence {
  Reference reference;
  std::vector<Curve> curves;
};

struct ConvergenceWish {
  std::vector<Method> methods;
  std::uint32_t most = 256;  ///< samples
  std::uint32_t repeats = 5;
  double warm_up = 0.5;          ///< seconds of rendering that are thrown away first
  double reference_share = 0.1;  ///< of the smallest error measured: the reference's own
  double reference_seconds = 120;
  std::string cache;
  bool fresh = false;
  std::function<void(const std::string&)> say;  ///< progress in words
};

Result<Convergence> measure_convergence(const Subject& subject, const ConvergenceWish& wish);

/// Slope of log(error) over log(samples) by least squares over the points of at least `from`
/// samples with a finite positive error; nothing with fewer than three.
std::optional<double> slope(const Curve& curve, double CurvePoint::*error, std::uint32_t from);

/// Where the curve's true error (or its estimate) comes to `error`. Nothing where one point is all
/// there is and lies above it, or where it does not fall.
std::optional<Crossing> crossing(const Curve& curve, double error,
                                 double CurvePoint::*of = &CurvePoint::rmse);

}  // namespace diaphane::render::bench
