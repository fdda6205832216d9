#include "renderd/scene/prepared_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "renderd/kernel/estimator.h"
#include "renderd/kernel/exact.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"
#include "volume/labels.h"

namespace diaphane::render {
namespace {

volume::Header turned_header() {
  volume::Header h;
  h.size = {40, 30, 20};
  h.spacing = {1, 1.5, 2};
  // A rotation: x to the head, y to the left, z to the back.
  h.direction = {0, 1, 0, 0, 0, 1, 1, 0, 0};
  return h;
}

volume::Volume volume_of(const volume::Header& header) {
  volume::Volume v;
  v.header = header;
  v.voxels.assign(header.voxel_count(), 100);
  v.voxels[0] = 0;
  volume::measure(v);
  return v;
}

TEST(PreparedScene, CameraEditKeepsTheTables) {
  const volume::Volume v = test::skull_volume();
  const ValueGrid grid = make_value_grid(v.voxels, size_of(v.header));
  diaphane::v1::Scene scene = test::skull_scene();
  const auto first = prepare_scene(scene, {64, 64}, v.header, grid);
  ASSERT_TRUE(first);
  diaphane::v1::Scene turned = scene;
  turned.mutable_camera()->mutable_eye()->set_x(-45);
  const auto second = prepare_scene(turned, {64, 64}, v.header, grid, &*first, &scene);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->transfer, first->transfer);
  turned.mutable_transfer_function()->set_extinction_per_mm(0.7);
  const auto third = prepare_scene(turned, {64, 64}, v.header, grid, &*first, &scene);
  ASSERT_TRUE(third);
  EXPECT_NE(third->transfer, first->transfer);
}

/// In the frame of a rotated volume, the camera ray through the middle of the picture meets the
/// target. This is the world's origin, the centre of the box, for any direction matrix.
TEST(PreparedScene, CentreOfTheImageLooksAtTheTarget) {
  for (const double distance : {100.0, 1e6}) {
    diaphane::v1::Scene scene = test::skull_scene();
    test::set_camera(scene, 0.6 * distance, -0.7 * distance, 0.3 * distance, 2000 / distance);
    const test::Prepared p(volume_of(turned_header()), scene, {64, 48});
    const CameraRay r = camera_ray<Features{}>(p.view(), 32, 24);
    const Float3 middle{20, 15, 10};
    const Float3 to = middle - r.ray.origin;
    const float along = dot(to, r.ray.direction) / dot(r.ray.direction, r.ray.direction);
    EXPECT_LT(length(r.ray.at(along) - middle), 1e-3f) << distance;
    EXPECT_LT(length(r.ray.origin - middle), 100.0f) << "begins near the box, however far the eye";
  }
}

TEST(PreparedScene, OrientationIsRightForAnyVolumeDirection) {
  // Seen from the front (eye at -y in the patient's space), the patient's left (+x) is on the right
  // of the picture, with the head up.
  diaphane::v1::Scene scene = test::skull_scene();
  test::set_camera(scene, 0, -300, 0, 30);
  const test::Prepared p(volume_of(turned_header()), scene, {64, 64});
  const auto view = p.view();
  const Float3 middle = camera_ray<Features{}>(view, 32, 32).direction;
  const Float3 right = camera_ray<Features{}>(view, 60, 32).direction - middle;
  const Float3 up = camera_ray<Features{}>(view, 32, 4).direction - middle;
  // The volume's y axis points to the patient's left, its x axis to the head.
  EXPECT_GT(right.y, 0.05f);
  EXPECT_NEAR(right.x, 0, 1e-5f);
  EXPECT_GT(up.x, 0.05f);
  EXPECT_NEAR(up.y, 0, 1e-5f);
}

TEST(PreparedScene, LockedLightStaysBesideTheCamera) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_lights();
  test::add_lamp(scene, 50, 30, 200, 20, 10);
  scene.mutable_lights(0)->set_camera_locked(true);
  const auto seen_from = [&](double x, double y, double z) {
    test::set_camera(scene, x, y, z, 30);
    const test::Prepared p(volume_of(turned_header()), scene);
    const AreaLight& light = p.scene().lights.at(0);
    const CameraView& c = p.scene().camera;
    const Float3 from_middle = light.corner - Float3{20, 22.5f, 20};  // the box's centre, mm
    return Float3{dot(from_middle, normalize(c.right)), dot(from_middle, normalize(c.up)),
                  -dot(from_middle, c.forward)};
  };
  const Float3 a = seen_from(0, -300, 0), b = seen_from(120, 200, 180);
  EXPECT_LT(length(a - Float3{40, 20, 200}), 1e-3f);
  EXPECT_LT(length(b - a), 1e-3f);
}

TEST(PreparedScene, OmitsUnneededFeatures) {
  diaphane::v1::Scene scene = test::skull_scene();
  const auto features = [&] {
    return test::Prepared(test::skull_volume(), scene).scene().features;
  };
  EXPECT_EQ(features(), Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment));
  test::add_lamp(scene, 0, 0, 90, 10, 0);
  EXPECT_FALSE(features().has(Feature::kManyLights)) << "a black lamp does not count";
  test::add_lamp(scene, 0, 0, 90, 10, 1);
  EXPECT_TRUE(features().has(Feature::kManyLights));
  scene.mutable_phase()->set_g(-0.2);
  EXPECT_TRUE(features().has(Feature::kAnisotropicPhase));
  scene.clear_lights();
  EXPECT_EQ(features(), Features{}.with(Feature::kAnisotropicPhase));
}

TEST(PreparedScene, SamplesEachKindOfLightByItsContribution) {
  const volume::Volume v = test::skull_volume();
  const auto strata = [&](double lamp, double sky) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.mutable_shading()->set_mode(diaphane::v1::Shading::SURFACE);
    scene.set_bounces(3);
    scene.clear_lights();
    if (lamp > 0) test::add_lamp(scene, -20, 15, 70, 40, lamp);
    if (sky > 0) test::add_sky(scene, sky);
    return strata_for(test::Prepared(v, scene).scene());
  };
  const auto lamps = [](const auto& of) { return of[static_cast<int>(Strategy::kAreaLight)]; };
  const auto skies = [](const auto& of) { return of[static_cast<int>(Strategy::kEnvironment)]; };
  const auto even = strata(30, 0.5), dim = strata(30, 0.001), bright = strata(0.01, 5);
  EXPECT_GT(lamps(dim), lamps(even));
  EXPECT_GT(skies(bright), skies(even));
  EXPECT_GE(skies(dim), 1);
  EXPECT_GE(lamps(bright), 1);
  EXPECT_EQ(skies(strata(30, 0)), 0);
  EXPECT_EQ(lamps(strata(0, 1)), 0);
  // The largest radiances that a scene may have, and very small ones.
  for (const auto& of : {strata(1e15, 1e15), strata(1e15, 1e-30), strata(1e-30, 1e15)}) {
    EXPECT_GE(lamps(of), 1);
    EXPECT_GE(skies(of), 1);
    EXPECT_LE(std::accumulate(of.begin(), of.end(), 0), kMostHits);
  }
}

TEST(PreparedScene, RefusesInvalidCanvas) {
  const volume::Volume v = test::skull_volume();
  const ValueGrid grid = make_value_grid(v.voxels, size_of(v.header));
  for (const Canvas canvas :
       {Canvas{0, 10}, Canvas{10, 0}, Canvas{16385, 10}, Canvas{8193, 8192}, Canvas{10, 10, 11, 20},
        Canvas{10, 10, 1, 0}, Canvas{10, 10, 0, 16385}}) {
    const auto p = prepare_scene(test::skull_scene(), canvas, v.header, grid);
    ASSERT_FALSE(p);
    EXPECT_EQ(p.error().field, "canvas");
  }
}

TEST(CheckVolume, NamesTheInvalidField) {
  const auto field = [](auto&& change) {
    volume::Volume v = test::constant_volume(4, 7);
    change(v);
    const auto checked = check_volume(v);
    return checked ? std::string() : checked.error().field;
  };
  EXPECT_EQ(field([](auto&) {}), "");
  EXPECT_EQ(field([](auto& v) { v.header.size[1] = 0; }), "size");
  EXPECT_EQ(field([](auto& v) { v.voxels.pop_back(); }), "size");
  EXPECT_EQ(field([](auto& v) { v.header.spacing[2] = 0; }), "spacing");
  EXPECT_EQ(field([](auto& v) { v.header.spacing[0] = std::nan(""); }), "spacing");
  EXPECT_EQ(field([](auto& v) { v.header.direction[0] = -1; }), "direction") << "mirrored";
  EXPECT_EQ(field([](auto& v) { v.header.direction[1] = 0.5; }), "direction");
}

TEST(Presets, AreValidAndShowTheWholeBoxForEveryVolume) {
  volume::Volume ct = test::skull_volume();
  ct.header.modality = volume::Modality::kCt;
  const volume::Volume others[] = {ct, test::constant_volume(1, 0),
                                   test::constant_volume(5, -32768), volume_of(turned_header())};
  for (const volume::Volume& v : others) {
    const auto presets = presets_for(v.header, whole_box(v.header), true);
    ASSERT_GE(presets.size(), 4u);
    for (const auto& preset : presets) {
      const auto checked = check_scene(preset.scene());
      EXPECT_TRUE(checked) << preset.name() << ": " << (checked ? "" : checked.error().message);
      EXPECT_LT(preset.scene().camera().eye().y(), 0) << "in front of the patient";
    }
  }
  EXPECT_FALSE(preset_for(ct.header, whole_box(ct.header), "spectacles"));
}

TEST(Presets, ShowTheBrainWhereItIsKnown) {
  volume::Volume mr = test::skull_volume();
  mr.header.modality = volume::Modality::kMr;
  volume::Labels labels{mr.header.size, std::vector<std::uint8_t>(mr.voxels.size(), 1)};
  const Framing framing = whole_box(mr.header);
  mr.labels = volume::encode(labels);
  EXPECT_FALSE(brain_of(mr));
  EXPECT_EQ(presets_for(mr.header, framing, false).front().name(), "skin");
  const auto instead = preset_for(mr.header, framing, "brain");
  ASSERT_TRUE(instead) << "cards of MR scans ask for it";
  EXPECT_EQ(instead->name(), "skin");

  // Two voxels at the end of the volume.
  labels.voxels[labels.voxels.size() - 1] = labels.voxels[labels.voxels.size() - 2] = 4;
  mr.voxels[mr.voxels.size() - 1] = mr.voxels[mr.voxels.size() - 2] = 700;
  mr.labels = volume::encode(labels);
  const auto brain = brain_of(mr);
  ASSERT_TRUE(brain);
  EXPECT_EQ(brain->value, 700);
  EXPECT_DOUBLE_EQ(brain->framing.half_width[0], mr.header.spacing[0]);
  const auto presets = presets_for(mr.header, framing, false, brain);
  EXPECT_EQ(presets[0].name(), "brain");
  EXPECT_EQ(presets[1].name(), "through");
  for (const auto& preset : presets) {
    EXPECT_TRUE(check_scene(preset.scene())) << preset.name();
    const bool uses_labels = preset.name() == "brain" || preset.name() == "through";
    EXPECT_EQ(preset.scene().labels_size(), uses_labels ? 1 : 0);
  }
  EXPECT_EQ(presets[0].scene().labels(0).opacity(), 0) << "the rest is hidden";
  EXPECT_GT(presets[1].scene().labels(0).opacity(), 0);
  EXPECT_NE(presets[0].scene().transfer_function().SerializeAsString(),
            presets[1].scene().transfer_function().SerializeAsString())
      << "the page tells looks apart by them";
}

TEST(Presets, AirwaysPresetShowsTranslucentAirWalls) {
  volume::Volume ct = test::skull_volume();
  ct.header.modality = volume::Modality::kCt;
  const auto preset = preset_for(ct.header, whole_box(ct.header), "airways");
  ASSERT_TRUE(preset);
  const v1::TransferFunction& function = preset->scene().transfer_function();
  const auto extinction_at = [&](double hounsfield) {
    return function.extinction_per_mm() * material_at(function, hounsfield).opacity;
  };
  for (const double unseen : {-1000.0, -950.0, -100.0, 0.0, 50.0, 400.0, 1500.0}) {
    EXPECT_EQ(extinction_at(unseen), 0) << unseen;
  }
  constexpr double kWall = 2;  // mm
  const double through_wall = std::exp(-kWall * extinction_at(-550));
  EXPECT_LT(through_wall, 0.9) << "a wall is visible";
  EXPECT_GT(through_wall * through_wall, 0.4) << "the interior is visible";
}

}  // namespace
}  // namespace diaphane::render
