#include "renderd/cli/report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "renderd/kernel/features.h"

namespace diaphane::render::cli {
namespace {

TEST(Report, NamesEveryFeatureOnceAsCompiledInOrLeftOut) {
  const Outcome outcome{.engine = {"cpu", "2 threads", 0},
                        .progress = {8, 0.5, std::numeric_limits<double>::infinity()},
                        .stopped_by = StopReason::kSeconds,
                        .features = {"clip", "area light"}};
  const auto json = nlohmann::json::parse(report_json(Options{}, outcome));
  EXPECT_EQ(json["features"].size(), 2u);
  EXPECT_EQ(json["features"].size() + json["left_out"].size(), kFeatureCount);
  for (const auto& name : json["left_out"]) {
    EXPECT_NE(name, "clip");
    EXPECT_NE(name, "area light");
  }
  EXPECT_EQ(json["stopped_by"], "seconds");
  EXPECT_TRUE(json["estimated_error"].is_null()) << "unknown below two samples";
}

}  // namespace
}  // namespace diaphane::render::cli
