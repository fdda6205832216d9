// Behaviour of a program with the CUDA engine on a machine without a device.
#include <gtest/gtest.h>

#include "renderd/engine/cuda/engine.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {
namespace {

class CudaAbsenceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (make_cuda_engine()) GTEST_SKIP() << "a device answers here";
  }
};

TEST_F(CudaAbsenceTest, AutoFallsBackToTheCpu) {
  const auto engine = make_engine(EngineChoice::kAuto, 1);
  ASSERT_TRUE(engine) << engine.error().message;
  EXPECT_EQ((*engine)->info().engine, "cpu");
}

TEST_F(CudaAbsenceTest, ExplicitRequestReportsThatNoDeviceIsAvailable) {
  const auto engine = make_engine(EngineChoice::kCuda, 1);
  ASSERT_FALSE(engine);
  EXPECT_EQ(engine.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(engine.error().message.find("no CUDA device"), std::string::npos);
}

}  // namespace
}  // namespace diaphane::render
