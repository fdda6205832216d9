#include "renderd/scene/contrast_agent.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string_view>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

using Hounsfield = std::function<int(double x, double y, double z)>;

/// A CT of 60 mm with voxels of 1 mm. Coordinates are in mm from its centre.
volume::Volume ct(const Hounsfield& value) {
  volume::Volume volume;
  volume.header.size = {60, 60, 60};
  volume.header.spacing = {1, 1, 1};
  volume.header.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  volume.header.modality = volume::Modality::kCt;
  for (int z = 0; z < 60; ++z) {
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 60; ++x) {
        volume.voxels.push_back(static_cast<std::int16_t>(value(x - 29.5, y - 29.5, z - 29.5)));
      }
    }
  }
  volume::measure(volume);
  return volume;
}

constexpr int kTissue = 40, kBlood = 300, kDenseBone = 1200, kSpongyBone = 250;

/// A tube of 14 mm through tissue.
int tube(double x, double y, int inside) { return std::hypot(x, y) < 7 ? inside : kTissue; }

TEST(ContrastAgent, IsFoundInAVessel) {
  EXPECT_TRUE(shows_contrast_agent(ct([](auto x, auto y, auto) { return tube(x, y, kBlood); })));
}

TEST(ContrastAgent, IsNotFoundInTissueOrBone) {
  EXPECT_FALSE(shows_contrast_agent(ct([](auto x, auto y, auto) { return tube(x, y, kTissue); })));
  EXPECT_FALSE(
      shows_contrast_agent(ct([](auto x, auto y, auto) { return tube(x, y, kDenseBone); })));
  // A skull of 5 mm: spongy bone between two dense shells.
  EXPECT_FALSE(shows_contrast_agent(ct([](double x, double y, double z) {
    const double depth = 25 - std::hypot(x, y, z);
    if (depth < 0 || depth > 5) return kTissue;
    return depth < 1.5 || depth > 3.5 ? kDenseBone : kSpongyBone;
  })));
}

TEST(ContrastAgent, IsOnlyForCt) {
  volume::Volume mr = ct([](auto x, auto y, auto) { return tube(x, y, kBlood); });
  mr.header.modality = volume::Modality::kMr;
  EXPECT_FALSE(shows_contrast_agent(mr));
}

TEST(ContrastAgent, AcceptsVolumesSmallerThanACell) {
  volume::Volume tiny = ct([](auto, auto, auto) { return kBlood; });
  tiny.header.size = {1, 2, 1};
  tiny.voxels.resize(2);
  EXPECT_FALSE(shows_contrast_agent(tiny));
}

bool offers(const volume::Header& header, std::string_view look, bool contrast_agent = false) {
  for (const auto& preset : presets_for(header, whole_box(header), contrast_agent)) {
    if (preset.name() == look) return true;
  }
  return false;
}

TEST(Presets, OfferVesselsOnlyWhereTheScanShowsThem) {
  volume::Header header = ct([](auto, auto, auto) { return kTissue; }).header;
  EXPECT_TRUE(offers(header, "vessels", true));
  EXPECT_FALSE(offers(header, "vessels", false));
  EXPECT_TRUE(preset_for(header, whole_box(header), "vessels")) << "on request";
  // In other scans, blood is much brighter than tissue, or it isn't shown.
  header.modality = volume::Modality::kMr;
  header.percentiles = {0, 0, 5, 40, 90, 120, 140, 190};
  EXPECT_FALSE(offers(header, "vessels", true));
  header.percentiles = {0, 0, 5, 40, 90, 120, 190, 600};
  EXPECT_TRUE(offers(header, "vessels", false));
}

TEST(Presets, OfferTeethAndAirwaysOnlyWhereTheScanShowsThem) {
  const auto head = [](int bone, int air) {
    return ct([=](auto x, auto y, auto z) { return z > 20 ? air : tube(x, y, bone); }).header;
  };
  EXPECT_TRUE(offers(head(1800, -1000), "dense"));
  EXPECT_FALSE(offers(head(900, -1000), "dense"));
  EXPECT_TRUE(offers(head(1800, -1000), "airways"));
  EXPECT_FALSE(offers(head(1800, kTissue), "airways"));
}

}  // namespace
}  // namespace diaphane::render
