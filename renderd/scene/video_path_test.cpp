#include "renderd/scene/video_path.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>

#include <numbers>
#include <random>

#include "renderd/scene/camera.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/scene_mix.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;
using google::protobuf::util::MessageDifferencer;

v1::Scene seen_from(double x, double y, double z) {
  v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{100, 0.1}, {1000, 1}});
  scene.mutable_transfer_function()->set_extinction_per_mm(1);
  test::add_lamp(scene, 0, 0, 400, 100, 5);
  test::set_camera(scene, x, y, z, 40);
  scene.mutable_phase();
  scene.mutable_display()->mutable_background();
  return scene;
}

Double3 eye_of(const v1::Scene& scene) { return vector_of(scene.camera().eye()); }
Double3 target_of(const v1::Scene& scene) { return vector_of(scene.camera().target()); }
double distance_of(const v1::Scene& scene) { return length(eye_of(scene) - target_of(scene)); }

void expect_near(Double3 a, Double3 b, double within) {
  EXPECT_NEAR(a.x, b.x, within);
  EXPECT_NEAR(a.y, b.y, within);
  EXPECT_NEAR(a.z, b.z, within);
}

v1::Video video_of(v1::Video::Path path, std::uint32_t frames) {
  v1::Video video;
  video.set_path(path);
  video.set_frames(frames);
  video.set_frames_per_second(25);
  video.set_width(640);
  video.set_height(480);
  video.set_error(0.05);
  return video;
}

TEST(Turntable, RotatesOnceAboutTheVerticalAxisThroughTheTarget) {
  v1::Scene scene = seen_from(30, -500, 120);
  test::set(scene.mutable_camera()->mutable_target(), 10, 20, 30);
  const v1::Video video = video_of(v1::Video::TURNTABLE, 100);
  const Double3 first = eye_of(scene) - target_of(scene);
  for (std::uint32_t frame = 0; frame < 100; ++frame) {
    const v1::Scene seen = video_frame(video, {scene}, frame);
    const Double3 from = eye_of(seen) - target_of(seen);
    EXPECT_DOUBLE_EQ(from.z, first.z);
    EXPECT_NEAR(std::hypot(from.x, from.y), std::hypot(first.x, first.y), 1e-9);
    const double angle =
        std::atan2(first.x * from.y - first.y * from.x, first.x * from.x + first.y * from.y);
    EXPECT_NEAR(std::remainder(angle - 2 * std::numbers::pi * frame / 100, 2 * std::numbers::pi), 0,
                1e-9);
    expect_near(target_of(seen), target_of(scene), 0);
    EXPECT_TRUE(check_scene(seen));
  }
  EXPECT_TRUE(MessageDifferencer::Equals(video_frame(video, {scene}, 0), scene));
  const Double3 half = eye_of(video_frame(video, {scene}, 50)) - target_of(scene);
  expect_near(half, {-first.x, -first.y, first.z}, 1e-9);
}

TEST(Turntable, KeepsTheUpDirection) {
  v1::Scene scene = seen_from(0, -500, 100);
  test::set(scene.mutable_camera()->mutable_up(), 0.3, 0, 1);
  const CameraAxes before(scene.camera());
  const CameraAxes after(turned_about_target(scene, 0.3).camera());
  EXPECT_NEAR(after.up.z, before.up.z, 1e-12);
  EXPECT_NEAR(after.right.z, before.right.z, 1e-12);
}

TEST(Tour, VisitsEachKeyViewInOrder) {
  const std::vector<v1::Scene> keys{seen_from(0, -500, 0), seen_from(400, -100, 200),
                                    seen_from(0, 300, 50)};
  const v1::Video video = video_of(v1::Video::TOUR, 201);
  for (std::size_t key = 0; key < keys.size(); ++key) {
    EXPECT_TRUE(MessageDifferencer::Equals(
        video_frame(video, keys, static_cast<std::uint32_t>(100 * key)), keys[key]));
  }
}

// Each step of 1/1000 of a segment is a small part of the path, and the path has no sharp bend.
TEST(Tour, IsSmoothForRandomViews) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int round = 0; round < 20; ++round) {
    std::vector<v1::Scene> keys;
    for (int i = 0; i < 5; ++i) {
      Double3 from{number(random), number(random), 0.5 * number(random)};
      from = normalize(from) * (300 + 200 * number(random));
      v1::Scene key = seen_from(from.x, from.y, from.z);
      test::set(key.mutable_camera()->mutable_target(), 50 * number(random), 50 * number(random),
                50 * number(random));
      keys.push_back(std::move(key));
    }
    constexpr int kSteps = 1000;
    Double3 before{}, step_before{};
    for (int i = 0; i <= 4 * kSteps; ++i) {
      const v1::Scene seen = on_tour(keys, i / double(kSteps));
      ASSERT_TRUE(check_scene(seen)) << i;
      const Double3 eye = eye_of(seen);
      const Double3 step = eye - before;
      if (i > 1 && i % kSteps != 1) {  // at a key the speed may change, not the direction
        EXPECT_LT(length(step), 15) << i;
        EXPECT_LT(length(step - step_before), 1) << i;
      } else if (i > 1) {
        EXPECT_GT(dot(normalize(step), normalize(step_before)), 0.98) << i;
      }
      before = eye;
      step_before = step;
    }
  }
}

TEST(Tour, TakesTheShorterArcBetweenTwoViews) {
  const std::vector<v1::Scene> keys{seen_from(0, -500, 0), seen_from(500, 0, 0)};
  for (double at = 0; at <= 1; at += 0.05) {
    const v1::Scene seen = on_tour(keys, at);
    EXPECT_NEAR(distance_of(seen), 500, 1e-6) << "not through the patient";
    const double angle = std::numbers::pi / 2 * at;
    expect_near(eye_of(seen), {500 * std::sin(angle), -500 * std::cos(angle), 0}, 1e-6);
    EXPECT_NEAR(CameraAxes(seen.camera()).up.z, 1, 1e-9);
  }
}

TEST(Tour, StandsStillBetweenEqualViews) {
  const v1::Scene one = seen_from(0, -500, 0);
  for (const double at : {0.25, 0.5, 1.5, 1.9}) {
    const v1::Scene seen = on_tour({one, one, one}, at);
    expect_near(eye_of(seen), eye_of(one), 1e-6);
  }
}

TEST(SceneMix, InterpolatesNumbersOfScenesOfEqualStructure) {
  v1::Scene a = seen_from(0, -500, 0), b = a;
  b.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(0)->set_value(200);
  b.mutable_transfer_function()->mutable_channels(0)->mutable_diffuse()->set_r(0.4);
  b.mutable_lights(0)->mutable_rectangle()->mutable_radiance()->set_g(15);
  const v1::Scene half = mix_scenes(a, b, 0.5);
  EXPECT_DOUBLE_EQ(half.transfer_function().channels(0).opacity(0).value(), 150);
  EXPECT_DOUBLE_EQ(half.transfer_function().channels(0).diffuse().r(), 0.6);
  EXPECT_DOUBLE_EQ(half.lights(0).rectangle().radiance().g(), 10);
  EXPECT_TRUE(MessageDifferencer::Equals(mix_scenes(a, b, 0), a));
  EXPECT_TRUE(MessageDifferencer::Equals(mix_scenes(a, b, 1), b));
}

TEST(SceneMix, SwitchesOnlyPartsOfUnequalStructureHalfWay) {
  v1::Scene a = seen_from(0, -500, 0), b = a;
  test::add_sky(b, 1);
  b.mutable_transfer_function()->set_extinction_per_mm(3);
  EXPECT_EQ(mix_scenes(a, b, 0.49).lights_size(), 1);
  EXPECT_EQ(mix_scenes(a, b, 0.51).lights_size(), 2);
  EXPECT_DOUBLE_EQ(mix_scenes(a, b, 0.25).transfer_function().extinction_per_mm(), 1.5);
  EXPECT_DOUBLE_EQ(mix_scenes(a, b, 0.75).transfer_function().extinction_per_mm(), 2.5);
}

TEST(SceneMix, ChannelStructureIncludesItsNameAndPoints) {
  const v1::Scene a = seen_from(0, -500, 0);
  v1::Scene named = a, longer = a, off = a, focused = a;
  named.mutable_transfer_function()->mutable_channels(0)->set_name("skin");
  longer.mutable_transfer_function()->mutable_channels(0)->add_opacity()->set_value(2000);
  off.mutable_transfer_function()->mutable_channels(0)->set_disabled(true);
  focused.mutable_camera()->set_focal_distance(300);  // 0 means the distance of the target
  for (const v1::Scene* other : {&named, &longer, &off, &focused}) {
    EXPECT_FALSE(equal_in_kind(a, *other));
  }
  v1::Scene moved = a;
  moved.mutable_camera()->mutable_eye()->set_x(5);
  EXPECT_TRUE(equal_in_kind(a, moved));
}

// The edges of the two lamps point in opposite directions, so half way the mixture would have no
// area.
TEST(SceneMix, ReplacesInvalidMixtureByTheNearerScene) {
  v1::Scene a = seen_from(0, -500, 0), b = a;
  auto& lamp = *b.mutable_lights(0)->mutable_rectangle();
  lamp.mutable_u()->set_y(-lamp.u().y());
  ASSERT_TRUE(check_scene(b));
  EXPECT_TRUE(MessageDifferencer::Equals(mix_scenes(a, b, 0.5), b));
  EXPECT_TRUE(check_scene(mix_scenes(a, b, 0.4)));
}

TEST(CheckVideo, RefusesValuesOutOfRange) {
  const std::vector<v1::Scene> one{seen_from(0, -500, 0)}, two{one[0], seen_from(0, 500, 0)};
  EXPECT_TRUE(check_video(video_of(v1::Video::TURNTABLE, 250), one));
  EXPECT_TRUE(check_video(video_of(v1::Video::TOUR, 1500), two));
  using Change = void (*)(v1::Video&);
  const std::pair<const char*, Change> wrong[] = {
      {"frames", [](v1::Video& f) { f.set_frames(1); }},
      {"frames", [](v1::Video& f) { f.set_frames(1501); }},
      {"frames", [](v1::Video& f) { f.set_frames(0xffffffffu); }},
      {"framesPerSecond", [](v1::Video& f) { f.set_frames_per_second(9); }},
      {"framesPerSecond", [](v1::Video& f) { f.set_frames_per_second(61); }},
      {"width", [](v1::Video& f) { f.set_width(641); }},
      {"width", [](v1::Video& f) { f.set_width(14); }},
      {"height", [](v1::Video& f) { f.set_height(1922); }},
      {"error", [](v1::Video& f) { f.set_error(0); }},
      {"error", [](v1::Video& f) { f.set_error(std::nan("")); }},
      {"path", [](v1::Video& f) { f.clear_path(); }},
      {"path", [](v1::Video& f) { f.set_path(static_cast<v1::Video::Path>(7)); }}};
  for (const auto& [field, change] : wrong) {
    v1::Video video = video_of(v1::Video::TURNTABLE, 250);
    change(video);
    const auto refused = check_video(video, one);
    ASSERT_FALSE(refused) << field;
    EXPECT_EQ(refused.error().field, field);
  }
  EXPECT_FALSE(check_video(video_of(v1::Video::TOUR, 100), one));
  EXPECT_FALSE(check_video(video_of(v1::Video::TURNTABLE, 100), {}));
  EXPECT_FALSE(check_video(video_of(v1::Video::TOUR, 100), std::vector<v1::Scene>(17, one[0])));
  EXPECT_FALSE(check_video(video_of(v1::Video::TURNTABLE, 100), {v1::Scene{}}));
}

TEST(PhasesOfVideo, ShowsEachPhaseEquallyLongInEveryCycle) {
  v1::Video video = video_of(v1::Video::STANDING, 80);
  video.set_phase_cycles(2);
  const v1::Scene scene = seen_from(0, -500, 0);
  ASSERT_TRUE(check_video(video, {scene}, 10));
  std::vector<int> shown(10);
  for (std::uint32_t frame = 0; frame < 80; ++frame) {
    v1::Scene seen = video_frame(video, {scene}, frame, 10);
    EXPECT_EQ(seen.volume_phase(), frame / 4 % 10);
    ++shown[seen.volume_phase()];
    seen.clear_volume_phase();
    EXPECT_TRUE(MessageDifferencer::Equals(seen, scene)) << "the camera stands";
  }
  EXPECT_THAT(shown, testing::Each(8));
}

TEST(PhasesOfVideo, TurnsWhilePhasesPlay) {
  v1::Video video = video_of(v1::Video::TURNTABLE, 100);
  video.set_phase_cycles(5);
  const v1::Scene seen = video_frame(video, {seen_from(0, -500, 0)}, 50, 20);
  EXPECT_NEAR(eye_of(seen).y, 500, 1e-9);
  EXPECT_EQ(seen.volume_phase(), 10u);
}

TEST(PhasesOfVideo, RefusesPhasesThatCannotBePlayed) {
  const std::vector<v1::Scene> keys{seen_from(0, -500, 0)};
  v1::Video video = video_of(v1::Video::STANDING, 50);
  EXPECT_EQ(check_video(video, keys, 10).error().field, "phaseCycles");
  video.set_phase_cycles(51);
  EXPECT_EQ(check_video(video, keys, 10).error().field, "phaseCycles");
  video.set_phase_cycles(50);
  EXPECT_TRUE(check_video(video, keys, 10));
  EXPECT_EQ(check_video(video, keys, 1).error().field, "phaseCycles");
}

}  // namespace
}  // namespace diaphane::render
