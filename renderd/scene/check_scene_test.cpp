#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_folders.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

using Scene = diaphane::v1::Scene;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Fault {
  const char* field;
  std::function<void(Scene&)> make;
};

const Fault kFaults[] = {
    {"transferFunction.channels",
     [](Scene& s) { s.mutable_transfer_function()->clear_channels(); }},
    {"transferFunction.channels", [](Scene& s) { s.clear_transfer_function(); }},
    {"transferFunction.channels[0].opacity",
     [](Scene& s) { s.mutable_transfer_function()->mutable_channels(0)->clear_opacity(); }},
    {"transferFunction.channels[0].opacity[1].value",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(1)->set_value(-1);
     }},
    {"transferFunction.channels[0].opacity[1].value",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(1)->set_value(kNan);
     }},
    {"transferFunction.channels[0].opacity[0].opacity",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(0)->set_opacity(-0.1);
     }},
    {"transferFunction.channels[0].diffuse.g",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_diffuse()->set_g(1.01);
     }},
    {"transferFunction.extinctionPerMm",
     [](Scene& s) { s.mutable_transfer_function()->set_extinction_per_mm(-1); }},
    {"transferFunction.extinctionPerMm",
     [](Scene& s) { s.mutable_transfer_function()->set_extinction_per_mm(kNan); }},
    {"transferFunction.extinctionPerMm",
     [](Scene& s) { s.mutable_transfer_function()->set_extinction_per_mm(kInfinity); }},
    {"lights[0].rectangle.radiance.r",
     [](Scene& s) {
       s.mutable_lights(0)->mutable_rectangle()->mutable_radiance()->set_r(kInfinity);
     }},
    {"lights[0].rectangle.corner.z",
     [](Scene& s) { s.mutable_lights(0)->mutable_rectangle()->mutable_corner()->set_z(kNan); }},
    {"lights[0].rectangle.u",
     [](Scene& s) { s.mutable_lights(0)->mutable_rectangle()->clear_u(); }},
    {"lights[0].rectangle.v",
     [](Scene& s) {
       auto* r = s.mutable_lights(0)->mutable_rectangle();
       *r->mutable_v() = r->u();
     }},
    {"lights[1].environment.radiance.b",
     [](Scene& s) { s.mutable_lights(1)->mutable_environment()->mutable_radiance()->set_b(-0.5); }},
    {"lights[2]", [](Scene& s) { s.add_lights(); }},
    {"lights",
     [](Scene& s) {
       for (int i = 0; i < 10'000; ++i) test::add_sky(s, 1);
     }},
    {"camera", [](Scene& s) { s.clear_camera(); }},
    {"camera.eye.x", [](Scene& s) { s.mutable_camera()->mutable_eye()->set_x(kNan); }},
    {"camera.target", [](Scene& s) { *s.mutable_camera()->mutable_target() = s.camera().eye(); }},
    {"camera.up", [](Scene& s) { test::set(s.mutable_camera()->mutable_up(), -45, -80, -28); }},
    {"camera.up", [](Scene& s) { s.mutable_camera()->clear_up(); }},
    {"camera.verticalFovDegrees",
     [](Scene& s) { s.mutable_camera()->set_vertical_fov_degrees(180); }},
    {"camera.verticalFovDegrees",
     [](Scene& s) { s.mutable_camera()->set_vertical_fov_degrees(0); }},
    {"phase.g", [](Scene& s) { s.mutable_phase()->set_g(1); }},
    {"phase.g", [](Scene& s) { s.mutable_phase()->set_g(kNan); }},
    {"display.exposure", [](Scene& s) { s.mutable_display()->set_exposure(kInfinity); }},
    {"display.curve",
     [](Scene& s) {
       s.mutable_display()->set_curve(static_cast<diaphane::v1::Display::Curve>(2));
     }},
    {"display.backgroundEdge.g",
     [](Scene& s) { s.mutable_display()->mutable_background_edge()->set_g(kNan); }},
    {"display.background.r",
     [](Scene& s) { s.mutable_display()->mutable_background()->set_r(-1); }},
};

/// Cases of camera, clip, slices and paths, which most scenes leave out.
void set_clip_box(Scene& s, double low, double high) {
  test::set(s.mutable_clip()->mutable_box_low(), low, low, low);
  test::set(s.mutable_clip()->mutable_box_high(), high, high, high);
}
const Fault kFaultsOfTheView[] = {
    {"camera.verticalFovDegrees",
     [](Scene& s) { s.mutable_camera()->set_vertical_fov_degrees(kNan); }},
    {"camera.verticalFovDegrees",
     [](Scene& s) {
       s.mutable_camera()->set_orthographic_height(100);
       s.mutable_camera()->set_vertical_fov_degrees(kInfinity);
     }},
    {"camera.orthographicHeight",
     [](Scene& s) { s.mutable_camera()->set_orthographic_height(-1); }},
    {"camera.orthographicHeight",
     [](Scene& s) { s.mutable_camera()->set_orthographic_height(kNan); }},
    {"camera.orthographicHeight",
     [](Scene& s) { s.mutable_camera()->set_orthographic_height(kInfinity); }},
    {"camera.apertureRadius", [](Scene& s) { s.mutable_camera()->set_aperture_radius(-0.1); }},
    {"camera.apertureRadius", [](Scene& s) { s.mutable_camera()->set_aperture_radius(kNan); }},
    {"camera.apertureRadius", [](Scene& s) { s.mutable_camera()->set_aperture_radius(kInfinity); }},
    {"camera.focalDistance", [](Scene& s) { s.mutable_camera()->set_focal_distance(-5); }},
    {"camera.focalDistance", [](Scene& s) { s.mutable_camera()->set_focal_distance(kNan); }},
    {"camera.focalDistance", [](Scene& s) { s.mutable_camera()->set_focal_distance(1e-300); }},
    {"clip.boxHigh", [](Scene& s) { test::set(s.mutable_clip()->mutable_box_low(), 0, 0, 0); }},
    {"clip.boxLow", [](Scene& s) { test::set(s.mutable_clip()->mutable_box_high(), 0, 0, 0); }},
    {"clip.boxLow.x",
     [](Scene& s) {
       set_clip_box(s, -1, 1);
       s.mutable_clip()->mutable_box_low()->set_x(kNan);
     }},
    {"clip.boxHigh.z",
     [](Scene& s) {
       set_clip_box(s, -1, 1);
       s.mutable_clip()->mutable_box_high()->set_z(kInfinity);
     }},
    {"clip.boxHigh.y",
     [](Scene& s) {
       set_clip_box(s, -1, 1);
       s.mutable_clip()->mutable_box_high()->set_y(-2);
     }},
    {"clip.planes",
     [](Scene& s) {
       for (int i = 0; i < 7; ++i) {
         test::set(s.mutable_clip()->add_planes()->mutable_normal(), 1, 0, 0);
       }
     }},
    {"clip.planes[0].normal", [](Scene& s) { s.mutable_clip()->add_planes(); }},
    {"clip.planes[0].normal.y",
     [](Scene& s) { s.mutable_clip()->add_planes()->mutable_normal()->set_y(kNan); }},
    {"clip.planes[1].point.x",
     [](Scene& s) {
       test::set(s.mutable_clip()->add_planes()->mutable_normal(), 1, 0, 0);
       auto* plane = s.mutable_clip()->add_planes();
       test::set(plane->mutable_normal(), 1, 0, 0);
       plane->mutable_point()->set_x(kInfinity);
     }},
    {"slices.windowWidth",
     [](Scene& s) { s.mutable_slices()->mutable_coronal()->set_shown(true); }},
    {"slices.windowWidth",
     [](Scene& s) {
       s.mutable_slices()->mutable_coronal()->set_shown(true);
       s.mutable_slices()->set_window_width(-10);
     }},
    {"slices.windowWidth", [](Scene& s) { s.mutable_slices()->set_window_width(kNan); }},
    {"slices.windowCentre", [](Scene& s) { s.mutable_slices()->set_window_centre(kInfinity); }},
    {"slices.axial.position",
     [](Scene& s) { s.mutable_slices()->mutable_axial()->set_position(kNan); }},
    {"slices.colouring",
     [](Scene& s) {
       s.mutable_slices()->set_colouring(static_cast<diaphane::v1::Slices::Colouring>(9));
     }},
    {"bounces", [](Scene& s) { s.set_bounces(1025); }},
    {"labels[1].number",
     [](Scene& s) {
       s.add_labels()->set_number(7);
       s.add_labels()->set_number(7);
     }},
    {"labels[0].opacity",
     [](Scene& s) {
       s.add_labels()->set_number(7);
       s.mutable_labels(0)->set_opacity(1.01);
     }},
    {"labels[0].opacity",
     [](Scene& s) {
       s.add_labels()->set_number(7);
       s.mutable_labels(0)->set_opacity(kNan);
     }},
    {"labels[0].colour.b",
     [](Scene& s) {
       s.add_labels()->set_number(7);
       s.mutable_labels(0)->mutable_colour()->set_b(2);
     }},
    {"labels",
     [](Scene& s) {
       for (std::uint32_t i = 1; i <= 257; ++i) s.add_labels()->set_number(i);
     }},
    {"overlay.transferFunction.channels",
     [](Scene& s) { s.mutable_overlay()->mutable_transfer_function(); }},
    {"overlay.share", [](Scene& s) { s.mutable_overlay()->set_share(1.01); }},
    {"overlay.share", [](Scene& s) { s.mutable_overlay()->set_share(kNan); }},
    {"overlay.split", [](Scene& s) { s.mutable_overlay()->set_split(-0.01); }},
    {"overlay.mode",
     [](Scene& s) { s.mutable_overlay()->set_mode(static_cast<diaphane::v1::Overlay::Mode>(9)); }},
    {"highlight.radius", [](Scene& s) { s.mutable_highlight(); }},
    {"highlight.centre.y",
     [](Scene& s) {
       s.mutable_highlight()->set_radius(3);
       s.mutable_highlight()->mutable_centre()->set_y(kInfinity);
     }},
    {"highlight.colour.g",
     [](Scene& s) {
       s.mutable_highlight()->set_radius(3);
       s.mutable_highlight()->mutable_colour()->set_g(1.5);
     }},
    {"highlight.strength",
     [](Scene& s) {
       s.mutable_highlight()->set_radius(3);
       s.mutable_highlight()->set_strength(kNan);
     }},
    {"shading.mode",
     [](Scene& s) { s.mutable_shading()->set_mode(static_cast<diaphane::v1::Shading::Mode>(7)); }},
    {"shading.gradientScale", [](Scene& s) { s.mutable_shading()->set_gradient_scale(-1); }},
    {"shading.gradientScale", [](Scene& s) { s.mutable_shading()->set_gradient_scale(kNan); }},
    {"transferFunction.channels[0].specular.g",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_specular()->set_g(1.5);
     }},
    {"transferFunction.channels[0].gloss",
     [](Scene& s) { s.mutable_transfer_function()->mutable_channels(0)->set_gloss(kNan); }},
    {"transferFunction.channels[0].emission.b",
     [](Scene& s) {
       s.mutable_transfer_function()->mutable_channels(0)->mutable_emission()->set_b(-1);
     }},
};

TEST(CheckScene, NamesTheInvalidField) {
  std::vector<Fault> faults(std::begin(kFaults), std::end(kFaults));
  faults.insert(faults.end(), std::begin(kFaultsOfTheView), std::end(kFaultsOfTheView));
  for (const Fault& fault : faults) {
    Scene scene = test::skull_scene();
    ASSERT_TRUE(check_scene(scene));
    fault.make(scene);
    const auto checked = check_scene(scene);
    ASSERT_FALSE(checked) << fault.field;
    EXPECT_EQ(checked.error().code, ErrorCode::kInvalid);
    EXPECT_EQ(checked.error().field, fault.field);
    EXPECT_NE(checked.error().message.find(fault.field), std::string::npos);
  }
}

TEST(CheckScene, AcceptsMeaningfulExtremes) {
  Scene scene = test::skull_scene();
  scene.mutable_phase()->set_g(-0.999999);
  scene.mutable_transfer_function()->set_extinction_per_mm(1e6);
  scene.mutable_lights(1)->mutable_environment()->mutable_radiance()->set_r(1e12);
  EXPECT_TRUE(check_scene(scene));
  scene.mutable_transfer_function()->set_extinction_per_mm(0);
  scene.clear_lights();
  EXPECT_TRUE(check_scene(scene)) << "an invisible scene is valid";
}

TEST(SceneJson, RoundTrips) {
  const Scene scene = test::skull_scene();
  const auto again = scene_from_json(scene_to_json(scene));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->SerializeAsString(), scene.SerializeAsString());
}

/// Every scene file of the tests can be read, checked and prepared.
TEST(SceneJson, EveryTestSceneIsValid) {
  const volume::Volume volume = test::skull_volume();
  const ValueGrid grid = make_value_grid(volume.voxels, size_of(volume.header));
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::kScenes)) {
    if (entry.path().extension() != ".json") continue;
    std::ifstream file(entry.path());
    const std::string json{std::istreambuf_iterator<char>(file), {}};
    const auto scene = scene_from_json(json);
    ASSERT_TRUE(scene) << entry.path() << ": " << scene.error().message;
    const auto prepared = prepare_scene(*scene, {64, 64}, volume.header, grid);
    EXPECT_TRUE(prepared) << entry.path() << ": " << prepared.error().message;
    ++scenes;
  }
  EXPECT_GT(scenes, 8);
}

TEST(SceneJson, RefusesUnknownFieldByName) {
  const auto top = scene_from_json(R"({"colour": 1})");
  ASSERT_FALSE(top);
  EXPECT_EQ(top.error().field, "colour");
  const auto nested = scene_from_json(R"({"camera": {"verticalFov": 40}})");
  ASSERT_FALSE(nested);
  EXPECT_NE(nested.error().field.find("verticalFov"), std::string::npos) << nested.error().message;
}

TEST(SceneJson, RefusesTextThatIsNotAScene) {
  for (const char* text : {"", "[]", "{", "{\"phase\": {\"g\": \"much\"}}", "\xff\xfe"}) {
    const auto parsed = scene_from_json(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, ErrorCode::kInvalid);
    EXPECT_FALSE(parsed.error().message.empty());
  }
}

TEST(SceneJson, NanIsRefusedByTheCheckIfParsed) {
  const auto parsed = scene_from_json(R"({"phase": {"g": "NaN"}})");
  if (parsed) {
    EXPECT_FALSE(check_scene(*parsed));
  }
}

}  // namespace
}  // namespace diaphane::render
