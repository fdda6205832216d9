#include <gtest/gtest.h>

#include <vector>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {
namespace {

TEST(MakeEngine, AutoReportsWhyItDidNotChooseCuda) {
  std::vector<Error> reasons;
  const auto engine = make_engine(EngineChoice::kAuto, 1, {},
                                  [&](const Error& reason) { reasons.push_back(reason); });
  ASSERT_TRUE(engine) << engine.error().message;
  if ((*engine)->info().engine == "cuda") GTEST_SKIP() << "this machine has a CUDA device";
  ASSERT_EQ(reasons.size(), 1U);
  EXPECT_FALSE(reasons.front().message.empty());
  EXPECT_TRUE((*engine)->info().device.ends_with(", no GPU: " + reasons.front().message));
}

TEST(MakeEngine, ReportsNothingIfTheCpuWasChosen) {
  int reports = 0;
  ASSERT_TRUE(make_engine(EngineChoice::kCpu, 1, {}, [&](const Error&) { ++reports; }));
  EXPECT_EQ(reports, 0);
  EXPECT_EQ((*make_engine(EngineChoice::kCpu, 1))->info().device.find("GPU"), std::string::npos);
}

}  // namespace
}  // namespace diaphane::render
