#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "renderd/scene/presets.h"
#include "renderd/scene/texture.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_textures.h"

namespace diaphane::render {
namespace {

using Light = diaphane::v1::Light;
using Scene = diaphane::v1::Scene;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A scene with a rectangle, a disk, a sphere, a box and an environment as lights.
Scene lit_scene() {
  Scene scene = test::skull_scene();
  scene.clear_lights();
  test::add_lamp(scene, 0, 0, 90, 20, 5);
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_normal(), 0, -1, 0);
  d->set_radius(10);
  auto* s = scene.add_lights()->mutable_sphere();
  s->set_radius(10);
  auto* b = scene.add_lights()->mutable_box();
  test::set(b->mutable_u(), 1, 0, 0);
  test::set(b->mutable_v(), 0, 1, 0);
  test::set(b->mutable_w(), 0, 0, 1);
  test::add_sky(scene, 1);
  return scene;
}

struct Fault {
  const char* field;
  int light;
  std::function<void(Light&)> make;
};

const Fault kFaults[] = {
    {"lights[0].rectangle.texture", 0,
     [](Light& l) { l.mutable_rectangle()->mutable_texture()->set_picture("a cat"); }},
    {"lights[0].intensity", 0, [](Light& l) { l.set_intensity(-1); }},
    {"lights[0].intensity", 0, [](Light& l) { l.set_intensity(kNan); }},
    {"lights[0].intensity", 0, [](Light& l) { l.set_intensity(1e15); }},
    {"lights[1].disk.centre.y", 1,
     [](Light& l) { l.mutable_disk()->mutable_centre()->set_y(kNan); }},
    {"lights[1].disk.normal", 1, [](Light& l) { l.mutable_disk()->clear_normal(); }},
    {"lights[1].disk.radius", 1, [](Light& l) { l.mutable_disk()->set_radius(-1); }},
    {"lights[1].disk.radius", 1, [](Light& l) { l.mutable_disk()->set_radius(kNan); }},
    {"lights[1].disk.radius", 1, [](Light& l) { l.mutable_disk()->set_radius(1e-7); }},
    {"lights[1].disk.radiance.g", 1,
     [](Light& l) { l.mutable_disk()->mutable_radiance()->set_g(-1); }},
    {"lights[0].rectangle.texture.projectionDegrees", 0,
     [](Light& l) { l.mutable_rectangle()->mutable_texture()->set_projection_degrees(171); }},
    {"lights[1].disk.texture", 1, [](Light& l) { l.mutable_disk()->mutable_texture(); }},
    {"lights[2].sphere.centre.x", 2,
     [](Light& l) { l.mutable_sphere()->mutable_centre()->set_x(1e9); }},
    {"lights[2].sphere.radius", 2, [](Light& l) { l.mutable_sphere()->set_radius(1e8); }},
    {"lights[2].sphere.radiance.r", 2,
     [](Light& l) { l.mutable_sphere()->mutable_radiance()->set_r(kNan); }},
    {"lights[2].sphere.texture", 2,
     [](Light& l) {
       l.mutable_sphere()->mutable_texture()->set_picture(std::string(kMostTextureBytes + 1, 'x'));
     }},
    {"lights[3].box.u", 3, [](Light& l) { l.mutable_box()->clear_u(); }},
    {"lights[3].box.v", 3, [](Light& l) { *l.mutable_box()->mutable_v() = l.box().u(); }},
    {"lights[3].box.w", 3, [](Light& l) { test::set(l.mutable_box()->mutable_w(), 3, -2, 0); }},
    {"lights[3].box.radiance.b", 3,
     [](Light& l) { l.mutable_box()->mutable_radiance()->set_b(1e16); }},
    {"lights[4].environment.texture", 4,
     [](Light& l) { l.mutable_environment()->mutable_texture()->set_picture("\x89PNG"); }},
};

TEST(CheckLights, NamesTheInvalidFieldEvenOfADisabledLight) {
  for (const bool disabled : {false, true}) {
    for (const Fault& fault : kFaults) {
      Scene scene = lit_scene();
      ASSERT_TRUE(check_scene(scene));
      fault.make(*scene.mutable_lights(fault.light));
      scene.mutable_lights(fault.light)->set_disabled(disabled);
      const auto checked = check_scene(scene);
      ASSERT_FALSE(checked) << fault.field;
      EXPECT_EQ(checked.error().field, fault.field);
      EXPECT_NE(checked.error().message.find(fault.field), std::string::npos);
    }
  }
}

TEST(CheckLights, LimitsTheNumberOfLights) {
  Scene scene = lit_scene();
  while (scene.lights_size() < 4096) *scene.add_lights() = scene.lights(2);
  EXPECT_TRUE(check_scene(scene));
  while (scene.lights_size() < 10'000) *scene.add_lights() = scene.lights(2);
  const auto checked = check_scene(scene);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().field, "lights");
  EXPECT_NE(checked.error().message.find("4096"), std::string::npos);
}

TEST(CheckLights, AcceptsPointLightsAndAnIntensityOfATrillion) {
  Scene scene = lit_scene();
  scene.mutable_lights(1)->mutable_disk()->set_radius(0);
  scene.mutable_lights(2)->mutable_sphere()->set_radius(0);
  scene.mutable_lights(0)->set_intensity(1e12);
  EXPECT_TRUE(check_scene(scene));
}

}  // namespace
}  // namespace diaphane::render
