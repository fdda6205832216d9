#include "renderd/session/volume_facts.h"

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

TEST(KeptFacts, LiveAsLongAsTheirVolume) {
  KeptFacts kept;
  auto first = std::make_shared<NoVolume>();
  const auto second = std::make_shared<NoVolume>();
  VolumeFacts facts;
  facts.histogram.set_width(16);
  facts.coarse = std::make_shared<const CoarseVolume>();
  kept.add(first, facts);
  EXPECT_EQ(kept.of(*first).histogram.width(), 16);
  EXPECT_EQ(kept.of(*first).coarse, facts.coarse);
  EXPECT_EQ(kept.of(*second).histogram.width(), 0);
  EXPECT_EQ(kept.of(*second).coarse, nullptr);
  const NoVolume* const address = first.get();
  first.reset();
  kept.add(second, {});
  EXPECT_EQ(kept.of(*address).coarse, nullptr);
  EXPECT_EQ(facts.coarse.use_count(), 1);
}

TEST(KeptFacts, AreDroppedOnRequest) {
  KeptFacts kept;
  auto gone = std::make_shared<NoVolume>();
  const auto held = std::make_shared<NoVolume>();
  VolumeFacts facts;
  facts.coarse = std::make_shared<const CoarseVolume>();
  kept.add(gone, facts);
  kept.add(held, facts);
  gone.reset();
  kept.forget_expired();
  EXPECT_EQ(facts.coarse.use_count(), 2) << "ours, and that of the volume that is held";
  EXPECT_EQ(kept.of(*held).coarse, facts.coarse);
}

}  // namespace
}  // namespace diaphane::render
