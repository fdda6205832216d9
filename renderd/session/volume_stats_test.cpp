#include "renderd/session/volume_stats.h"

#include <gtest/gtest.h>

#include <memory>

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

}  // namespace
}  // namespace diaphane::render
