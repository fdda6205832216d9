// The looks are not overexposed, however the user sets the shading and the bounces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderd/engine/cpu/engine.h"
#include "renderd/scene/framing.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{32, 24};
constexpr std::uint32_t kSamples = 16;
/// Of the pixels that show the subject.
constexpr double kMostClipped = 0.005;
/// Pixels with a brighter component than that of the background show the subject.
constexpr int kBackground = 62;

/// A head of skin, fat, muscle and bone with vessels, teeth and an airway, in Hounsfield units.
volume::Volume head(volume::Modality modality) {
  volume::Volume volume =
      test::make_volume({48, 48, 48}, {4, 4, 4}, [&](double x, double y, double z) {
        const double a = (x - 24) / 18, b = (y - 24) / 21, c = (z - 24) / 21;
        const double r = std::sqrt(a * a + b * b + c * c);
        if (std::hypot(a, c + 0.4) < 0.15 && b < 0) return -1000.0;  // airway
        if (std::hypot(a - 0.3, b, c - 0.2) < 0.15) return 300.0;    // vessel
        if (std::hypot(a, b + 0.7, c + 0.7) < 0.2) return 2500.0;    // tooth
        if (r < 0.72) return 40.0;                                   // brain
        if (r < 0.82) return 1100.0;                                 // bone
        if (r < 0.88) return 55.0;                                   // muscle
        if (r < 0.94) return -100.0;                                 // fat
        return std::max(-1000.0, 60 - (r - 0.94) / 0.06 * 1060);     // skin
      });
  if (modality != volume::Modality::kCt) {
    for (auto& value : volume.voxels) value = static_cast<std::int16_t>((value + 1000) / 4);
    volume::measure(volume);
  }
  volume.header.modality = modality;
  return volume;
}

/// Returns the part of the subject's pixels that have a component of 255.
double clipped_part(FrameRenderer& renderer, const diaphane::v1::Scene& scene) {
  EXPECT_TRUE(renderer.set_scene(scene, kCanvas));
  EXPECT_TRUE(renderer.render(kSamples, nullptr));
  PictureRgb8 picture;
  EXPECT_TRUE(renderer.display(picture));
  int subject = 0, clipped = 0;
  for (std::size_t i = 0; i + 2 < picture.pixels.size(); i += 3) {
    const int most = std::max({picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]});
    subject += most > kBackground ? 1 : 0;
    clipped += most == 255 ? 1 : 0;
  }
  EXPECT_GT(subject, 20);
  return static_cast<double>(clipped) / std::max(subject, 1);
}

TEST(Clipping, NoLookIsOverexposedWithAnyShadingAndBounces) {
  const auto engine = make_cpu_engine(2);
  double without_curve = 0;
  for (const auto modality : {volume::Modality::kCt, volume::Modality::kMr}) {
    const volume::Volume volume = head(modality);
    const auto renderer = engine->renderer(engine->load(volume).value(), 1, 0).value();
    for (const auto& preset : presets_for(volume.header, whole_box(volume.header), true)) {
      for (const auto mode : {diaphane::v1::Shading::PHASE, diaphane::v1::Shading::SURFACE,
                              diaphane::v1::Shading::HYBRID}) {
        for (const std::uint32_t bounces : {1u, 4u, 16u}) {
          diaphane::v1::Scene scene = preset.scene();
          scene.mutable_shading()->set_mode(mode);
          scene.set_bounces(bounces);
          EXPECT_LT(clipped_part(*renderer, scene), kMostClipped)
              << preset.name() << ", mode " << mode << ", bounces " << bounces;
        }
      }
      // The same light on the linear curve clips, so the test would notice.
      diaphane::v1::Scene linear = preset.scene();
      linear.mutable_display()->set_curve(diaphane::v1::Display::LINEAR);
      without_curve = std::max(without_curve, clipped_part(*renderer, linear));
    }
  }
  EXPECT_GT(without_curve, kMostClipped);
}

}  // namespace
}  // namespace diaphane::render
