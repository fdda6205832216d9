#include "bench/renderer/multi_process_engine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render::bench {
namespace {

constexpr Canvas kCanvas{16, 16};

PictureRgbF picture_by(Engine& engine, std::uint64_t seed, std::uint64_t first,
                       std::uint32_t samples, Progress* progress = nullptr) {
  const auto volume = engine.load(test::skull_volume()).value();
  const auto renderer = engine.renderer(volume, seed, first).value();
  EXPECT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
  EXPECT_TRUE(renderer->render(samples, [] { return false; }));
  PictureRgbF picture;
  EXPECT_TRUE(renderer->radiance(picture));
  if (progress != nullptr) *progress = renderer->progress();
  return picture;
}

/// The pictures of three devices, each with its own range of samples, weighted by count.
TEST(MultiProcessEngine, AveragesItsDevicesWeightedBySampleCount) {
  const auto multi = make_multi_process_engine(EngineChoice::kCpu, 3, 1).value();
  Progress progress;
  const PictureRgbF merged = picture_by(*multi, 7, 5, 20, &progress);
  EXPECT_EQ(progress.samples, 20u);
  const auto engine = make_cpu_engine(1);
  std::vector<double> expected(merged.pixels.size());
  double squared = 0;
  const std::uint32_t counts[] = {7, 7, 6};
  for (std::uint64_t k = 0; k < 3; ++k) {
    Progress own;
    const PictureRgbF part = picture_by(*engine, 7, 5 + (k << 40), counts[k], &own);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      expected[i] += static_cast<double>(part.pixels[i]) * counts[k] / 20;
    }
    squared += std::pow(own.error * counts[k] / 20, 2);
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_NEAR(merged.pixels[i], expected[i], 1e-5 * (1 + expected[i])) << i;
  }
  EXPECT_NEAR(progress.error, std::sqrt(squared), 1e-12);
}

TEST(MultiProcessEngine, SupportsFewerSamplesThanDevices) {
  const auto multi = make_multi_process_engine(EngineChoice::kCpu, 4, 1).value();
  const auto engine = make_cpu_engine(1);
  const PictureRgbF one = picture_by(*multi, 7, 0, 1), alone = picture_by(*engine, 7, 0, 1);
  EXPECT_EQ(one.pixels, alone.pixels);
}

TEST(MultiProcessEngine, ReportsErrorsOfItsDevices) {
  const auto multi = make_multi_process_engine(EngineChoice::kCpu, 2, 1).value();
  volume::Volume wrong = test::skull_volume();
  wrong.header.spacing[0] = -1;
  const auto loaded = multi->load(wrong);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInvalid);
  const auto volume = multi->load(test::skull_volume()).value();
  const auto renderer = multi->renderer(volume, 1, 0).value();
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(std::nan(""));
  EXPECT_FALSE(renderer->set_scene(scene, kCanvas));
  EXPECT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
}

}  // namespace
}  // namespace diaphane::render::bench
