#include "renderd/cli/options.h"

#include <gtest/gtest.h>

#include <vector>

namespace diaphane::render::cli {
namespace {

std::variant<Options, EarlyExit> parse_words(std::vector<const char*> words) {
  words.insert(words.begin(), "diaphane-render");
  return parse(static_cast<int>(words.size()), words.data());
}

void expect_refused(const std::vector<const char*>& words, const std::string& because) {
  const auto parsed = parse_words(words);
  const auto* early_exit = std::get_if<EarlyExit>(&parsed);
  ASSERT_NE(early_exit, nullptr) << "not refused: " << because;
  EXPECT_EQ(early_exit->exit_code, kExitUsage);
  EXPECT_NE(early_exit->text.find(because), std::string::npos) << early_exit->text;
}

TEST(RenderOptions, ParsesEveryOption) {
  const auto parsed =
      parse_words({"scan",     "--scene",  "s.json",      "--size",    "640x480", "--samples",
                   "7",        "--engine", "cuda",        "--threads", "3",       "--seed",
                   "9",        "--out",    "a.ppm",       "--json",    "-",       "--estimator",
                   "tracking", "--points", "independent", "--mis",     "scatter"});
  const auto* options = std::get_if<Options>(&parsed);
  ASSERT_NE(options, nullptr) << std::get<EarlyExit>(parsed).text;
  EXPECT_EQ(options->input, "scan");
  EXPECT_EQ(options->scene_file, "s.json");
  EXPECT_EQ(options->canvas.width, 640u);
  EXPECT_EQ(options->canvas.height, 480u);
  EXPECT_EQ(options->stop_rule().samples, 7u);
  EXPECT_EQ(options->engine, EngineChoice::kCuda);
  EXPECT_EQ(options->threads, 3u);
  EXPECT_EQ(options->seed, 9u);
  EXPECT_EQ(options->picture, "a.ppm");
  EXPECT_EQ(options->report, "-");
  EXPECT_EQ(options->method, (Method{Walk::kTracking, false, Mis::kScatter}));
}

TEST(RenderOptions, ErrorOrTimeLimitReplacesTheDefaultSampleCount) {
  const auto rule_of = [](std::vector<const char*> words) {
    words.insert(words.begin(), {"scan", "--preset", "bone", "--out", "a.ppm"});
    const auto parsed = parse_words(words);
    return std::get<Options>(parsed).stop_rule();
  };
  EXPECT_EQ(rule_of({}).samples, 64u);
  EXPECT_EQ(rule_of({"--error", "0.05"}).samples, StopRule::kMostSamples);
  EXPECT_EQ(rule_of({"--error", "0.05"}).error, 0.05);
  EXPECT_EQ(rule_of({"--seconds", "1e1"}).samples, StopRule::kMostSamples);
  EXPECT_EQ(rule_of({"--seconds", "1e1"}).seconds, 10.0);
  EXPECT_EQ(rule_of({"--seconds", "3", "--samples", "5"}).samples, 5u);
}

TEST(RenderOptions, ParsesAHighlight) {
  const auto parsed = parse_words(
      {"scan", "--preset", "bone", "--out", "a.ppm", "--highlight", "-10.5,20,-3e1,15"});
  const auto* options = std::get_if<Options>(&parsed);
  ASSERT_NE(options, nullptr) << std::get<EarlyExit>(parsed).text;
  EXPECT_EQ(options->highlight, (std::array{-10.5, 20.0, -30.0, 15.0}));
  for (const char* wrong : {"1,2,3", "1,2,3,4,5", "1,2,3,x", "", "1 2 3 4"}) {
    expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--highlight", wrong},
                   "X,Y,Z,RADIUS");
  }
}

TEST(RenderOptions, ListingPresetsNeedsNoPicture) {
  const auto parsed = parse_words({"scan", "--list-presets"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_TRUE(std::get<Options>(parsed).list_presets);
}

TEST(RenderOptions, RefusesInvalidOptionsByName) {
  expect_refused({"scan", "--preset", "bone"}, "--out");
  expect_refused({"--preset", "bone", "--out", "a.ppm"}, "INPUT");
  expect_refused({"scan", "--out", "a.ppm"}, "--scene or --preset");
  expect_refused({"scan", "--scene", "s", "--preset", "bone", "--out", "a.ppm"}, "excludes");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--samplez", "3"}, "--samplez");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--samples", "0"}, "--samples");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--samples", "1e9"}, "--samples");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--seed", "-1"}, "--seed");
  for (const char* number : {"0", "-1", "nan", "inf", "1e", "", "x", "1e300"}) {
    expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--error", number}, "--error");
    expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--seconds", number},
                   "--seconds");
  }
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--bounces", "1025"}, "--bounces");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--bounces", "0"}, "--bounces");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--engine", "gpu"}, "--engine");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--estimator", "euler"},
                 "--estimator");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--points", "sobol"}, "--points");
  expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--mis", "none"}, "--mis");
  expect_refused({"scan", "--preset", "bone", "--out", "a.jpg"}, ".png");
  expect_refused({"scan", "--preset", "bone", "--out", "/no/such/folder/a.ppm"}, "no such folder");
  for (const char* size : {"512", "0x5", "512x", "x512", "512x512x2", "-5x5", "99999x5", "a"}) {
    expect_refused({"scan", "--preset", "bone", "--out", "a.ppm", "--size", size}, "--size");
  }
}

TEST(RenderOptions, HelpNamesEveryOptionAndExitCode) {
  const auto parsed = parse_words({"--help"});
  const auto* early_exit = std::get_if<EarlyExit>(&parsed);
  ASSERT_NE(early_exit, nullptr);
  EXPECT_EQ(early_exit->exit_code, 0);
  for (const char* word :
       {"--scene",  "--preset",  "--size",    "--samples",   "--error",  "--seconds", "--bounces",
        "--engine", "--threads", "--seed",    "--estimator", "--points", "--mis",     "--out",
        "--json",   "--quiet",   "--denoise", ".nrrd",       "64",       "73"}) {
    EXPECT_NE(early_exit->text.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace diaphane::render::cli
