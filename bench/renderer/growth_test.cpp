#include "bench/renderer/growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/renderer/synthetic_volume.h"
#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render::bench {
namespace {

GrowthSubject cube(std::uint32_t n, std::vector<Canvas> canvases) {
  return {std::to_string(n) + "^3", [n] { return synthetic_cube(n); }, std::move(canvases)};
}

GrowthOptions small_options() {
  GrowthOptions options;
  options.scene = test::skull_scene();
  options.repeats = 2;
  options.most = 8;
  options.seconds = 2;
  return options;
}

TEST(SyntheticVolume, CubeContainsTheSameObject) {
  const volume::Volume flat = synthetic_volume(64), tall = synthetic_cube(64);
  EXPECT_EQ(tall.header.size, (std::array<std::uint32_t, 3>{64, 64, 64}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(tall.header.size[i] * tall.header.spacing[i],
                flat.header.size[i] * flat.header.spacing[i], 1e-9);
  }
  // The tolerance covers the coarser grid of 64 x 64 x 27 voxels, and the voxels of the shell that
  // the noise changes.
  const auto filled = [](const volume::Volume& v) {
    double n = 0;
    for (const std::int16_t voxel : v.voxels) n += voxel != 0;
    return n / static_cast<double>(v.voxels.size());
  };
  EXPECT_NEAR(filled(tall), filled(flat), 0.02);
}

TEST(Growth, ReportsARowPerVolumeCanvasAndWalk) {
  const auto engine = make_cpu_engine(1);
  std::vector<std::string> seen;
  GrowthOptions options = small_options();
  options.each = [&](const GrowthRow& row) { seen.push_back(growth_text(row)); };
  const auto rows =
      measure_growth(*engine, {cube(16, {{16, 16}}), cube(32, {{16, 16}, {32, 24}})}, options);
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 6u);
  EXPECT_EQ(seen.size(), 6u);
  std::set<std::string> lines(seen.begin(), seen.end());
  EXPECT_EQ(lines.size(), 6u);
  for (const GrowthRow& row : *rows) {
    EXPECT_FALSE(row.left_out);
    EXPECT_GT(row.load, 0);
    EXPECT_GT(row.prepare, 0);
    EXPECT_GT(row.edit.median, 0);
    EXPECT_GT(row.pass.median, 0);
    EXPECT_GT(row.in_a_row, 0);
    EXPECT_GT(row.processors, 0);
    EXPECT_LT(row.processors, 2 * row.pass.median + 2) << "one thread";
    EXPECT_GE(row.volume_bytes, 2u * row.size[0] * row.size[1] * row.size[2]);
    EXPECT_GT(row.acceleration_bytes, 0u);
    EXPECT_GE(row.film_bytes, 40u * row.canvas.width * row.canvas.height);
    ASSERT_FALSE(row.points.empty());
    EXPECT_EQ(row.points[0].samples, 2u);
    for (const CurvePoint& point : row.points) EXPECT_TRUE(std::isfinite(point.estimate));
  }
  const std::string csv = growth_csv(*rows, "cpu");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  const auto json = nlohmann::json::parse(growth_json(*rows, engine->info(), options));
  EXPECT_EQ(json["rows"].size(), 6u);
}

TEST(Growth, StopsMeasuringWhenTheTargetErrorIsReached) {
  const auto engine = make_cpu_engine(1);
  GrowthOptions options = small_options();
  options.walks = {Walk::kTracking};
  options.most = 64;
  options.seconds = 1e9;
  const auto at = [&](double target) {
    options.target = target;
    return measure_growth(*engine, {cube(16, {{16, 16}})}, options).value().at(0);
  };
  const GrowthRow at_once = at(100);
  EXPECT_EQ(at_once.points.size(), 1u);
  EXPECT_EQ(at_once.to_target->how, Crossing::How::kFirst);
  const GrowthRow never = at(1e-6);
  EXPECT_EQ(never.points.size(), 6u) << "2 to 64 samples";
  EXPECT_EQ(never.to_target->how, Crossing::How::kProlonged);
  EXPECT_DOUBLE_EQ(never.to_target->milliseconds, never.to_target->samples * never.in_a_row);
  const double middle = std::sqrt(never.points[2].estimate * never.points[3].estimate);
  const GrowthRow between = at(middle);
  EXPECT_EQ(between.points.size(), 4u);
  EXPECT_GT(between.to_target->samples, 8);
  EXPECT_LT(between.to_target->samples, 16);
}

TEST(Growth, RefusesInvalidSceneAndNamesTheField) {
  const auto engine = make_cpu_engine(1);
  GrowthOptions options = small_options();
  options.scene.mutable_transfer_function()->clear_channels();
  const auto rows = measure_growth(*engine, {cube(16, {{16, 16}})}, options);
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(rows.error().field.empty());
}

}  // namespace
}  // namespace diaphane::render::bench
