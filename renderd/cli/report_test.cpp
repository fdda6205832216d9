#include "renderd/cli/report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "renderd/kernel/features.h"

namespace diaphane::render::cli {
namespace {

TEST(Report, ListsEveryFeatureOnceAsUsedOrOmitted) {
  const Outcome outcome{.engine = {"cpu", "2 threads", 0},
                        .progress = {8, 0.5, std::numeric_limits<double>::infinity(), -0.5},
                        .stopped_by = StopReason::kSeconds,
                        .features = {"clip", "area light"},
                        .kernel = {}};
  const auto json = nlohmann::json::parse(report_json(Options{}, outcome));
  EXPECT_EQ(json["features"].size(), 2u);
  EXPECT_EQ(json["features"].size() + json["left_out"].size(), kFeatureCount);
  for (const auto& name : json["left_out"]) {
    EXPECT_NE(name, "clip");
    EXPECT_NE(name, "area light");
  }
  EXPECT_EQ(json["stopped_by"], "seconds");
  EXPECT_EQ(json["denoised"], false);
  EXPECT_EQ(json["automatic_exposure"], -0.5);
  EXPECT_TRUE(json["estimated_error"].is_null()) << "unknown below two samples";
}

TEST(Report, ContainsTheErrorAfterEachPass) {
  Outcome outcome;
  outcome.curve.add({2, 0.25, 0.5});
  outcome.curve.add({8, 1, 0.25});
  const auto curve = nlohmann::json::parse(report_json(Options{}, outcome))["error_curve"];
  const nlohmann::json expected{{{"samples", 2}, {"milliseconds", 250.0}, {"error", 0.5}},
                                {{"samples", 8}, {"milliseconds", 1000.0}, {"error", 0.25}}};
  EXPECT_EQ(curve, expected);
}

TEST(Report, DescribesTheKernel) {
  Outcome outcome;
  list_features(Features{}.with(Feature::kClip), outcome.kernel);
  auto kernel = nlohmann::json::parse(report_json(Options{}, outcome))["kernel"];
  EXPECT_EQ(kernel["compiled_in"], nlohmann::json{"clip"});
  EXPECT_EQ(kernel["left_out"].size(), kFeatureCount - 1);
  EXPECT_EQ(kernel["variant"], "ahead of time");
  EXPECT_TRUE(kernel["registers"].is_null()) << "a CPU has no register count";
  EXPECT_FALSE(kernel.contains("note"));
  outcome.kernel.origin = KernelOrigin::kForThisScene;
  outcome.kernel.registers = 64;
  outcome.kernel.note = "no compiler";
  kernel = nlohmann::json::parse(report_json(Options{}, outcome))["kernel"];
  EXPECT_EQ(kernel["variant"], "compiled for this scene");
  EXPECT_EQ(kernel["registers"], 64);
  EXPECT_EQ(kernel["note"], "no compiler");
}

}  // namespace
}  // namespace diaphane::render::cli
