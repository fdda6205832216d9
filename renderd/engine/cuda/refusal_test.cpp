#include "renderd/engine/cuda/refusal.h"

#include <gtest/gtest.h>

namespace diaphane::render::cuda {
namespace {

const Error kNoDevice{ErrorCode::kUnavailable, "no CUDA device is available (cudaErrorX)", {}};

TEST(Refusal, NamesTheMissingDriver) {
  const Error error = explain_no_device(kNoDevice, 0, 13000);
  EXPECT_EQ(error.code, ErrorCode::kUnavailable);
  EXPECT_EQ(error.message, "no CUDA device is available: no NVIDIA driver is installed");
}

TEST(Refusal, NamesOutdatedDriver) {
  EXPECT_EQ(explain_no_device(kNoDevice, 12020, 13000).message,
            "no CUDA device is available: the NVIDIA driver supports CUDA up to 12.2, but CUDA 13 "
            "is required");
}

TEST(Refusal, KeepsTheMessageWithoutADevice) {
  EXPECT_EQ(explain_no_device(kNoDevice, 13000, 13020).message, kNoDevice.message);
}

TEST(Refusal, NamesInsufficientComputeCapability) {
  const Error error = explain_refusal(kNoDevice, {"Tesla V100", 70, 16ULL << 30});
  EXPECT_EQ(error.code, ErrorCode::kUnavailable);
  EXPECT_EQ(error.message, "Tesla V100 has compute capability 7.0, but 7.5 or later is required");
}

TEST(Refusal, DoesNotBlameTheComputeCapabilityOfTuring) {
  EXPECT_EQ(explain_refusal(kNoDevice, {"Tesla T4", 75, 16ULL << 30}).message,
            "Tesla T4: " + kNoDevice.message);
}

TEST(Refusal, NamesTheMemoryOfAFullDevice) {
  const Error full{ErrorCode::kOutOfMemory, "not enough memory on the device", {}};
  EXPECT_EQ(explain_refusal(full, {"NVIDIA A2", 86, 2ULL << 30}).message,
            "NVIDIA A2 (2048 MiB) has too little free memory to start the CUDA engine");
}

TEST(Refusal, NamesTheDeviceOfAnyOtherError) {
  const Error lost{ErrorCode::kDeviceLost, "the CUDA device was lost", {}};
  const Error error = explain_refusal(lost, {"NVIDIA H100", 90, 80ULL << 30});
  EXPECT_EQ(error.code, ErrorCode::kDeviceLost);
  EXPECT_EQ(error.message, "NVIDIA H100: the CUDA device was lost");
}

}  // namespace
}  // namespace diaphane::render::cuda
