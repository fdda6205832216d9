#include "renderd/film/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace diaphane::render {
namespace {

WhiteHistogram histogram_of(const std::vector<float>& values) {
  WhiteHistogram histogram;
  for (const float value : values) ++histogram.counts[white_bin(value)];
  return histogram;
}

TEST(ExposureTest, TheMeanIsThatOfTheValuesWithinABin) {
  std::vector<float> values;
  double sum = 0;
  for (int i = 0; i < 1000; ++i) {
    values.push_back(std::exp2(static_cast<float>(i % 200) / 10.0f - 12.0f));
    sum += static_cast<double>(values.back());
  }
  EXPECT_NEAR(metering_of(histogram_of(values)).mean, sum / 1000, sum / 1000 / 32);
}

TEST(ExposureTest, BlackPixelsCountAndNoPixelsGiveNothing) {
  EXPECT_EQ(metering_of(histogram_of({0, 0, 1.03125f, 1.03125f})).mean, 0.515625);
  EXPECT_EQ(metering_of(WhiteHistogram{}).mean, 0);
  EXPECT_EQ(metering_of(histogram_of({0, 0})).mean, 0);
}

TEST(ExposureTest, AWellExposedPictureStaysAsItIs) {
  for (const double mean : {kDarkestMean, 0.23, kBrightestMean}) {
    EXPECT_EQ(automatic_stops(mean), 0);
  }
}

TEST(ExposureTest, OtherPicturesAreBroughtToTheNearerEnd) {
  EXPECT_NEAR(automatic_stops(4 * kBrightestMean), -2, 1e-12);
  EXPECT_NEAR(automatic_stops(kDarkestMean / 8), 3, 1e-12);
}

TEST(ExposureTest, TheCorrectionIsContinuous) {
  double before = automatic_stops(0.001);
  for (double mean = 0.001; mean < 100; mean *= 1.01) {
    const double now = automatic_stops(mean);
    EXPECT_LE(now, before);
    EXPECT_LE(before - now, std::log2(1.01) + 1e-12);
    before = now;
  }
}

TEST(ExposureTest, TheCorrectionIsLimited) {
  EXPECT_EQ(automatic_stops(1e-20), kUpToBrighter);
  EXPECT_EQ(automatic_stops(1e20), -kUpToDarker);
}

TEST(ExposureTest, WithoutAMeanThereIsNoCorrection) {
  for (const double mean : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(automatic_stops(mean), 0);
  }
}

}  // namespace
}  // namespace diaphane::render
