#include <gtest/gtest.h>

#include <cmath>

#include "bench/renderer/convergence.h"
#include "bench/renderer/convergence_report.h"
#include "bench/renderer/synthetic_volume.h"
#include "renderd/engine/cpu/engine.h"
#include "renderd/math/random.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render::bench {
namespace {

Reference grey_reference(double level, double own_error) {
  Reference r;
  r.canvas = {100, 100};
  r.mean.assign(30'000, level);
  r.contents.assign(10'000, 1);
  r.error = own_error;
  r.white = 1;
  return r;
}

TEST(PictureError, MeasuresTheDifferenceOfDisplayedValues) {
  const Reference reference = grey_reference(0.2, 0);
  PictureRgbF picture{reference.canvas, std::vector<float>(30'000, 0.3f)};
  const PictureError error = error_against(reference, picture);
  EXPECT_NEAR(error.rmse, std::pow(0.3, 1 / 2.2) - std::pow(0.2, 1 / 2.2), 1e-6);
  EXPECT_EQ(error.pixels, 10'000u);
}

TEST(PictureError, IgnoresBackgroundAndNonFinitePixels) {
  Reference reference = grey_reference(0.2, 0);
  for (std::size_t i = 5000; i < 10'000; ++i) reference.contents[i] = 0;
  PictureRgbF picture{reference.canvas, std::vector<float>(30'000, 0.2f)};
  for (std::size_t i = 15'000; i < 30'000; ++i) picture.pixels[i] = 9;
  picture.pixels[3] = NAN;
  picture.pixels[29'999] = INFINITY;
  const PictureError error = error_against(reference, picture);
  EXPECT_NEAR(error.rmse, 0, 1e-7);
  EXPECT_EQ(error.non_finite, 2u);
}

TEST(PictureError, WhiteIsThe99thPercentileOfContentPixels) {
  std::vector<double> mean(30'000);
  std::vector<std::uint8_t> contents(10'000, 1);
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = static_cast<double>(i) / 30'000;
  EXPECT_NEAR(white_of(mean, contents), 0.99, 1e-4);
  for (std::size_t i = 5000; i < 10'000; ++i) contents[i] = 0;
  EXPECT_NEAR(white_of(mean, contents), 0.495, 1e-4);
  EXPECT_EQ(white_of(std::vector<double>(30'000, 0.0), contents), 1);
}

TEST(PictureError, SubtractsTheNoiseOfTheReference) {
  EXPECT_NEAR(without_noise_of(grey_reference(0, 0.03), 0.05), 0.04, 1e-12);
  EXPECT_EQ(without_noise_of(grey_reference(0, 0.03), 0.02), 0);
}

Curve straight(double error, double exponent, double milliseconds) {
  Curve curve;
  for (std::uint32_t n = 1; n <= 256; n *= 2) {
    CurvePoint point;
    point.samples = n;
    point.milliseconds = milliseconds * n;
    point.rmse = error * std::pow(n, exponent);
    point.estimate = n < 2 ? INFINITY : point.rmse;
    curve.points.push_back(point);
  }
  return curve;
}

TEST(Curve, SlopeAndCrossingOfAPowerLawAreExact) {
  const Curve curve = straight(0.4, -0.5, 3);
  EXPECT_NEAR(*slope(curve, &CurvePoint::rmse, 1), -0.5, 1e-12);
  EXPECT_NEAR(*slope(curve, &CurvePoint::estimate, 1), -0.5, 1e-12)
      << "infinite values are skipped";
  const Crossing c = *crossing(curve, 0.05);
  EXPECT_NEAR(c.samples, 64, 1e-9);
  EXPECT_NEAR(c.milliseconds, 192, 1e-9);
  EXPECT_EQ(c.how, Crossing::How::kBetween);
  const Crossing odd = *crossing(curve, 0.07);
  EXPECT_NEAR(odd.samples, std::pow(0.4 / 0.07, 2), 1e-9);
}

TEST(Curve, ReportsExtrapolatedAndMissingCrossings) {
  EXPECT_EQ(crossing(straight(0.04, -0.5, 3), 0.05)->how, Crossing::How::kFirst);
  EXPECT_EQ(crossing(straight(0.04, -0.5, 3), 0.05)->milliseconds, 3);
  const Crossing far = *crossing(straight(3.2, -0.5, 3), 0.05);
  EXPECT_EQ(far.how, Crossing::How::kProlonged);
  EXPECT_NEAR(far.samples, 4096, 1e-6);
  EXPECT_FALSE(crossing(Curve{}, 0.05));
  EXPECT_FALSE(crossing(straight(0.4, 0.0, 3), 0.05)) << "never";
}

TEST(SyntheticVolume, HasContentsEmptySpaceAndTheExtentOfTheCranium) {
  const volume::Volume v = synthetic_volume(32);
  EXPECT_EQ(v.header.size[2], 13u);
  EXPECT_NEAR(v.header.size[2] * v.header.spacing[2], 162, 0.1);
  EXPECT_EQ(v.header.minimum, 0);
  EXPECT_EQ(v.header.maximum, 30'000);
  std::size_t empty = 0;
  for (const std::int16_t voxel : v.voxels) empty += voxel == 0;
  EXPECT_GT(empty, v.voxels.size() / 4);
  EXPECT_LT(empty, v.voxels.size() * 9 / 10);
  EXPECT_EQ(hash_of(v), hash_of(synthetic_volume(32)));
  EXPECT_NE(hash_of(v), hash_of(synthetic_volume(33)));
}

}  // namespace
}  // namespace diaphane::render::bench
