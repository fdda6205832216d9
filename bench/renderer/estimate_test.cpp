// The error that the renderer reports with each picture, compared with the true one.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/renderer/convergence.h"
#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render::bench {
namespace {

Convergence measure(const v1::Scene& scene, ConvergenceOptions options) {
  const auto engine = make_cpu_engine(0);
  const volume::Volume volume = test::skull_volume();
  options.warm_up = 0;
  options.reference_share = 0.2;
  options.reference_seconds = 1e9;
  return measure_convergence({engine.get(), engine->load(volume).value(), 0, scene, {32, 32}},
                             options)
      .value();
}

/// Both kinds of points on the skull, by tracking.
const Convergence& measured() {
  static const Convergence result = [] {
    ConvergenceOptions options;
    options.methods = {{Walk::kTracking, false}, {Walk::kTracking, true}};
    options.most = 256;
    options.repeats = 8;
    return measure(test::skull_scene(), options);
  }();
  return result;
}

/// About 400 pixels count, their colours are correlated, and there are 8 pictures, so a root mean
/// square of half differences has a spread of 1 / sqrt(2 * 400 * 8) = 1.3%. The true error has the
/// same spread, and the reference less. 0.1 is five times the combined spread, which gives a
/// significance of 1e-5 for all six comparisons.
TEST(Estimate, IsWithinTenPercentFrom64SamplesForBothPointSets) {
  for (const Curve& curve : measured().curves) {
    for (const CurvePoint& point : curve.points) {
      EXPECT_EQ(point.non_finite + point.dropped, 0u);
      if (point.samples < 64) continue;
      EXPECT_NEAR(point.estimate / point.rmse, 1, 0.1)
          << (curve.method.low_discrepancy ? "low-discrepancy, " : "independent, ")
          << point.samples;
    }
  }
}

/// With repeated strong forward scattering, a few samples are tens of times as bright as white, and
/// the display clips them. Over 32 pictures, the ratio is known to about 1%: 0.92 at 64 samples and
/// 0.97 at 128. With these seeds the result is always the same; with others the test would fail
/// once in forty runs. Without the bias of the display curve the ratio is 0.88, which is also two
/// spreads too low.
TEST(Estimate, IsWithinTenPercentOfTheTrueErrorDespiteClipping) {
  v1::Scene scene = test::skull_scene();
  scene.mutable_phase()->set_g(0.8);
  scene.set_bounces(32);
  ConvergenceOptions options;
  options.methods = {{Walk::kTracking, false}};
  options.most = 128;
  options.repeats = 32;
  const Convergence result = measure(scene, options);
  for (const CurvePoint& point : result.curves[0].points) {
    if (point.samples < 64) continue;
    EXPECT_NEAR(point.estimate / point.rmse, 1, 0.1) << point.samples;
  }
}

/// From 16 to 256 samples, a slope has a spread of 1.3% / (ln 2 sqrt(10)) = 0.006. The display
/// curve bends the line by less than 0.02 in this range.
TEST(Estimate, TrueErrorConvergesAtMonteCarloRate) {
  const auto& curves = measured().curves;
  EXPECT_NEAR(*slope(curves[0], &CurvePoint::rmse, 16), -0.5, 0.03);
  EXPECT_LT(*slope(curves[1], &CurvePoint::rmse, 16), -0.47);
}

TEST(Estimate, LowDiscrepancyPointsAreNeverWorse) {
  const auto& curves = measured().curves;
  for (std::size_t i = 0; i < curves[0].points.size(); ++i) {
    EXPECT_LT(curves[1].points[i].rmse, 1.05 * curves[0].points[i].rmse)
        << curves[0].points[i].samples << " samples";
  }
}

TEST(Estimate, ReferenceErrorIsFarBelowTheMeasuredErrors) {
  const Convergence& result = measured();
  EXPECT_LT(result.reference.error, 0.25 * result.curves[1].points.back().rmse);
  EXPECT_GT(result.reference.samples, 16 * 256);
}

}  // namespace
}  // namespace diaphane::render::bench
