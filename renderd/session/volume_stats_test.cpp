#include "renderd/session/volume_stats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace diaphane::render {
namespace {

class NoVolume final : public DeviceVolume {
 public:
  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override { return 0; }

 private:
  volume::Header header_;
};

TEST(VolumeStatsCache, LiveAsLongAsTheirVolume) {
  VolumeStatsCache cache;
  auto first = std::make_shared<NoVolume>();
  const auto second = std::make_shared<NoVolume>();
  VolumeStats stats;
  stats.histogram.set_width(16);
  stats.coarse = std::make_shared<const CoarseVolume>();
  cache.add(first, stats);
  EXPECT_EQ(cache.of(*first).histogram.width(), 16);
  EXPECT_EQ(cache.of(*first).coarse, stats.coarse);
  EXPECT_EQ(cache.of(*second).histogram.width(), 0);
  EXPECT_EQ(cache.of(*second).coarse, nullptr);
  const NoVolume* const address = first.get();
  first.reset();
  cache.add(second, {});
  EXPECT_EQ(cache.of(*address).coarse, nullptr);
  EXPECT_EQ(stats.coarse.use_count(), 1);
}

TEST(VolumeStatsCache, AreDroppedOnRequest) {
  VolumeStatsCache cache;
  auto gone = std::make_shared<NoVolume>();
  const auto held = std::make_shared<NoVolume>();
  VolumeStats stats;
  stats.coarse = std::make_shared<const CoarseVolume>();
  cache.add(gone, stats);
  cache.add(held, stats);
  gone.reset();
  cache.forget_expired();
  EXPECT_EQ(stats.coarse.use_count(), 2) << "one reference here and one of the volume in use";
  EXPECT_EQ(cache.of(*held).coarse, stats.coarse);
}

/// A phantom whose voxels lie obliquely and have unequal spacing: a sphere of 20 mm radius at
/// 100 HU, a box of 16 x 24 x 32 mm along the patient's axes that alternates between -50 and
/// 150 HU, and air.
volume::Volume phantom() {
  volume::Volume volume;
  volume::Header& header = volume.header;
  header.size = {150, 110, 50};
  header.spacing = {0.6, 0.8, 1.25};
  header.direction = {0.8, -0.36, 0.48, 0.6, 0.48, -0.64, 0, 0.8, 0.6};
  volume.label_set.table = {{5, "sphere", {}}, {9, "box", {}}, {11, "nowhere", {}}};
  volume.label_set.labels.size = header.size;
  for (std::uint32_t z = 0; z < 50; ++z) {
    for (std::uint32_t y = 0; y < 110; ++y) {
      for (std::uint32_t x = 0; x < 150; ++x) {
        const double mx = (x + 0.5 - 75) * 0.6, my = (y + 0.5 - 55) * 0.8;
        const double mz = (z + 0.5 - 25) * 1.25;
        const bool in_sphere = std::hypot(mx + 22, my, mz) <= 20;
        const auto along = [&](std::size_t k) {
          const auto& axes = header.direction;
          return std::abs(axes[3 * k] * (mx - 21.5) + axes[3 * k + 1] * my + axes[3 * k + 2] * mz);
        };
        const bool in_box = along(0) <= 8 && along(1) <= 12 && along(2) <= 16;
        volume.label_set.labels.voxels.push_back(in_sphere ? 1 : in_box ? 2 : 0);
        volume.voxels.push_back(in_sphere ? 100 : in_box ? ((x + y + z) % 2 ? 150 : -50) : -1000);
      }
    }
  }
  volume::measure(volume);
  return volume;
}

TEST(VolumeStats, LabelVolumesAreWithinOnePercentOfAPhantom) {
  const v1::Labels labels = stats_of(phantom()).labels;
  ASSERT_EQ(labels.labels_size(), 3);
  const double sphere = 4.0 / 3 * std::numbers::pi * 20 * 20 * 20;
  EXPECT_NEAR(labels.labels(0).volume(), sphere, 0.01 * sphere);
  constexpr double kBox = 16.0 * 24 * 32;
  EXPECT_NEAR(labels.labels(1).volume(), kBox, 0.01 * kBox);
}

TEST(VolumeStats, LabelsHaveTheStatisticsOfTheirVoxels) {
  const v1::Labels labels = stats_of(phantom()).labels;
  ASSERT_EQ(labels.labels_size(), 3);
  EXPECT_EQ(labels.labels(0).mean(), 100);
  EXPECT_EQ(labels.labels(0).deviation(), 0);
  const v1::Labels::Label& box = labels.labels(1);
  EXPECT_EQ(box.minimum(), -50);
  EXPECT_EQ(box.maximum(), 150);
  // One half of 20,480 voxels may have 100 more than the other.
  EXPECT_NEAR(box.mean(), 50, 1);
  EXPECT_NEAR(box.deviation(), 100, 0.1);
  const v1::Labels::Label& nowhere = labels.labels(2);
  EXPECT_EQ(nowhere.volume(), 0);
  EXPECT_EQ(nowhere.mean(), 0);
  EXPECT_GT(nowhere.minimum(), nowhere.maximum());
}

}  // namespace
}  // namespace diaphane::render
