#include "renderd/cli/command.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render::cli {
namespace {

namespace fs = std::filesystem;

/// A small volume and a scene file in a separate directory.
class Command : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/diaphane-render-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder_ = name;
    volume::Volume volume = test::skull_volume();
    ASSERT_TRUE(volume::write(volume, folder_ / "volume"));
    write_scene(test::skull_scene());
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_scene(const diaphane::v1::Scene& scene) const {
    std::ofstream(folder_ / "scene.json") << scene_to_json(scene);
  }
  Options options() const {
    Options o;
    o.input = folder_ / "volume";
    o.scene_file = folder_ / "scene.json";
    o.picture = folder_ / "out.ppm";
    o.report = folder_ / "out.json";
    o.canvas = {24, 16};
    o.engine = EngineChoice::kCpu;
    o.threads = 1;
    o.quiet = true;
    return o;
  }
  std::string text_of(const char* name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  nlohmann::json report() const { return nlohmann::json::parse(text_of("out.json")); }

  fs::path folder_;
};

TEST_F(Command, ListsThePresetsOfTheScanAndRendersNothing) {
  Options o = options();
  o.list_presets = true;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run(o), 0);
  const std::string listed = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(listed.starts_with("skin\nmuscle\n")) << listed;
  EXPECT_FALSE(fs::exists(o.picture));
  o.input = folder_ / "missing";
  EXPECT_EQ(run(o), kExitNoInput);
}

TEST_F(Command, EnvironmentReplacesTheLights) {
  Options o = options();
  o.samples = 4;
  // Half of the panorama is black, so that the picture differs from one without light.
  std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
  file += std::string("\x80\x80\x80\x81", 4) + std::string(4, '\0');
  std::ofstream(folder_ / "sky.hdr", std::ios::binary) << file;
  o.environment = folder_ / "sky.hdr";
  ASSERT_EQ(run(o), 0);
  const auto features = report()["features"];
  EXPECT_NE(std::ranges::find(features, "textured environment"), features.end());
  EXPECT_EQ(std::ranges::find(features, "area lights"), features.end());
  std::ofstream(folder_ / "sky.hdr", std::ios::binary) << "no panorama";
  EXPECT_EQ(run(o), kExitData);
  o.environment = folder_ / "missing.hdr";
  EXPECT_EQ(run(o), kExitNoInput);
}

TEST_F(Command, StopsAtTheRequestedError) {
  Options o = options();
  o.error = 0.05;
  ASSERT_EQ(run(o), 0);
  EXPECT_EQ(report()["stopped_by"], "error");
  EXPECT_LE(report()["estimated_error"], 0.05);
  EXPECT_GE(report()["samples"], 2);
  const auto curve = report()["error_curve"];
  EXPECT_EQ(curve.front()["samples"], 2) << "the error is unknown below two samples";
  EXPECT_EQ(curve.back()["samples"], report()["samples"]);
  EXPECT_EQ(curve.back()["error"], report()["estimated_error"]);
  EXPECT_EQ(curve.back()["milliseconds"], report()["milliseconds"]);
}

TEST_F(Command, StopsAtTheTimeLimitAfterAtLeastOneSample) {
  Options o = options();
  o.seconds = 1e-9;
  ASSERT_EQ(run(o), 0);
  EXPECT_EQ(report()["stopped_by"], "seconds");
  EXPECT_EQ(report()["samples"], 1);
  EXPECT_EQ(text_of("out.ppm").size(), std::string("P6\n24 16\n255\n").size() + 24 * 16 * 3);
}

TEST_F(Command, ReadingTheErrorDoesNotChangeTheImage) {
  Options o = options();
  o.samples = 40;
  ASSERT_EQ(run(o), 0);
  const std::string plain = text_of("out.ppm");
  o.error = 1e-9;
  o.seconds = 1e6;
  ASSERT_EQ(run(o), 0);
  EXPECT_EQ(report()["stopped_by"], "samples");
  EXPECT_EQ(report()["samples"], 40);
  EXPECT_EQ(text_of("out.ppm"), plain);
}

TEST_F(Command, BouncesOptionOverridesTheScene) {
  Options o = options();
  o.samples = 1;
  o.bounces = 3;
  ASSERT_EQ(run(o), 0);
  const auto features = report()["features"];
  EXPECT_NE(std::find(features.begin(), features.end(), "bounces"), features.end());
}

TEST_F(Command, InvalidSceneKeepsThePreviousFile) {
  Options o = options();
  o.samples = 1;
  ASSERT_EQ(run(o), 0);
  const std::string before = text_of("out.ppm");
  diaphane::v1::Scene bad = test::skull_scene();
  bad.mutable_clip()->add_planes();
  write_scene(bad);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run(o), kExitData);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("clip.planes[0].normal"), std::string::npos) << said;
  EXPECT_EQ(text_of("out.ppm"), before);
}

}  // namespace
}  // namespace diaphane::render::cli
