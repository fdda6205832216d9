#include "renderd/scene/overlay_looks.h"

#include <gtest/gtest.h>

#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

using volume::Modality;

volume::Header header_of(Modality modality) {
  volume::Header header;
  header.size = {64, 64, 64};
  header.modality = modality;
  header.minimum = modality == Modality::kCt ? -1024 : 0;
  header.maximum = 3000;
  header.percentiles = {0, 0, 0, 50, 200, 400, 900, 1500};
  return header;
}

std::string names(Modality first, Modality second) {
  std::string names;
  for (const auto& look : overlay_looks(header_of(first), header_of(second))) {
    names += look.name() + " ";
  }
  return names;
}

TEST(OverlayLooks, FitThePairOfScans) {
  EXPECT_EQ(names(Modality::kCt, Modality::kPt), "hot tint same ");
  EXPECT_EQ(names(Modality::kMr, Modality::kCt), "bone tint same ");
  EXPECT_EQ(names(Modality::kCt, Modality::kCt), "tint same bone ");
  EXPECT_EQ(names(Modality::kMr, Modality::kMr), "tint same hot ");
}

TEST(OverlayLooks, AreScenesThatCanBeShown) {
  for (const Modality first : {Modality::kCt, Modality::kMr, Modality::kPt, Modality::kOther}) {
    for (const Modality second : {Modality::kCt, Modality::kMr, Modality::kPt, Modality::kOther}) {
      for (const auto& look : overlay_looks(header_of(first), header_of(second))) {
        diaphane::v1::Scene scene = test::skull_scene();
        *scene.mutable_overlay() = look.overlay();
        const auto checked = check_scene(scene);
        EXPECT_TRUE(checked) << look.name() << ": " << checked.error().message;
        EXPECT_GT(look.overlay().share(), 0);
      }
    }
  }
}

TEST(OverlayLooks, HotMetalGrowsDenserAndBrighterWithTheUptake) {
  const auto looks = overlay_looks(header_of(Modality::kCt), header_of(Modality::kPt));
  const auto& function = looks.front().overlay().transfer_function();
  EXPECT_EQ(material_at(function, 250).opacity, 0) << "tissue";
  double opacity = 0, brightness = 0;
  for (const double value : {500.0, 800.0, 1200.0, 1500.0, 2900.0}) {
    const Material m = material_at(function, value);
    EXPECT_GE(m.opacity, opacity) << value;
    const double now =
        (m.weighted_emission.x + m.weighted_emission.y + m.weighted_emission.z) / m.weight;
    EXPECT_GE(now, brightness) << value;
    opacity = m.opacity;
    brightness = now;
  }
  EXPECT_EQ(opacity, 1);
}

TEST(OverlayLooks, TintDiffersFromTheUsualLookInColourOnly) {
  const auto looks = overlay_looks(header_of(Modality::kMr), header_of(Modality::kMr));
  auto tint = looks[0].overlay().transfer_function(), same = looks[1].overlay().transfer_function();
  EXPECT_NE(tint.SerializeAsString(), same.SerializeAsString());
  for (auto* function : {&tint, &same}) {
    for (auto& channel : *function->mutable_channels()) channel.clear_diffuse();
  }
  EXPECT_EQ(tint.SerializeAsString(), same.SerializeAsString());
}

}  // namespace
}  // namespace diaphane::render
