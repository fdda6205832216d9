#include "renderd/cli/command.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
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

/// A NIfTI label volume of the size of test::skull_volume(), whose first `layers` slices have the
/// label 10.
std::string labels_of_skull(std::int16_t width, int layers) {
  std::string file(352, '\0');
  const auto put = [&](std::size_t at, auto value) {
    std::memcpy(&file[at], &value, sizeof value);
  };
  put(0, std::int32_t{348});
  const std::int16_t dim[] = {3, width, 48, 30};
  for (std::size_t i = 0; i < 4; ++i) put(40 + 2 * i, dim[i]);
  put(70, std::int16_t{2});  // uint8
  const float steps[] = {1, 1, 1, 1.6F};
  for (std::size_t i = 0; i < 4; ++i) put(76 + 4 * i, steps[i]);
  put(108, 352.0F);
  std::memcpy(&file[344], "n+1", 4);
  const auto slice = static_cast<std::size_t>(width) * 48;
  const auto marked = slice * static_cast<std::size_t>(layers);
  return file + std::string(marked, '\x0a') + std::string(30 * slice - marked, '\0');
}

TEST_F(Command, ShowsAndHidesLabels) {
  Options o = options();
  o.samples = 8;
  ASSERT_EQ(run(o), 0);
  const std::string plain = text_of("out.ppm");
  o.label_file = folder_ / "labels.nii";
  std::ofstream(o.label_file, std::ios::binary) << labels_of_skull(48, 30);
  testing::internal::CaptureStderr();
  const int exit_code = run(o);
  const std::string complaint = testing::internal::GetCapturedStderr();
  if (complaint.find("DIAPHANE_INGEST") != std::string::npos) GTEST_SKIP() << complaint;
  ASSERT_EQ(exit_code, 0) << complaint;
  const auto features = report()["features"];
  EXPECT_NE(std::ranges::find(features, "labels"), features.end());
  EXPECT_NE(text_of("out.ppm"), plain) << "the colour of the label";
  o.labels = {*parse_label("10=0")};
  ASSERT_EQ(run(o), 0);
  const std::string hidden = text_of("out.ppm");
  EXPECT_EQ(std::set(hidden.end() - 3 * 24 * 16, hidden.end()).size(), 1u) << "only the sky";
  o.labels = {*parse_label("10=solo")};
  ASSERT_EQ(run(o), 0);
  EXPECT_NE(text_of("out.ppm"), hidden);
  o.labels = {*parse_label("Liver=0")};
  EXPECT_EQ(run(o), kExitData);
  o.labels = {};
  std::ofstream(o.label_file, std::ios::binary) << labels_of_skull(47, 30);
  EXPECT_EQ(run(o), kExitData) << "labels of another scan";
  o.label_file = folder_ / "missing.nii";
  EXPECT_EQ(run(o), kExitNoInput);
}

TEST_F(Command, ListsLabelsAndRendersNothing) {
  Options o = options();
  o.label_file = folder_ / "labels.nii";
  o.list_labels = true;
  std::ofstream(o.label_file, std::ios::binary) << labels_of_skull(48, 5);
  testing::internal::CaptureStdout();
  const int exit_code = run(o);
  const std::string listed = testing::internal::GetCapturedStdout();
  EXPECT_FALSE(fs::exists(o.picture));
  if (exit_code == kExitData) GTEST_SKIP() << "built without DIAPHANE_INGEST";
  EXPECT_TRUE(listed.starts_with("10\t#")) << listed;
  EXPECT_NE(listed.find("\t18.4 ml\t"), std::string::npos) << "48 x 48 x 5 voxels of 1.6 mm³";
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
