// The kernels compile at run time. Needs the compiler's library, no device.
#include "renderd/engine/cuda_nvrtc.h"

#include <gtest/gtest.h>

#include <string_view>

#include "renderd/engine/cuda_kernel_sources.h"
#include "renderd/engine/cuda_trace.h"
#include "renderd/kernel/variants.h"

namespace diaphane::render::cuda {
namespace {

/// What an engine may launch; a kernel that is added belongs here.
const KernelTemplate* const kKernels[] = {&kTraceKernel};

class NvrtcTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto nvrtc = Nvrtc::load();
    if (!nvrtc) GTEST_SKIP() << nvrtc.error().message;
    nvrtc_ = *nvrtc;
  }
  std::shared_ptr<const Nvrtc> nvrtc_;
};

/// Feature sets that differ much: nothing, what is in the program, each feature alone.
TEST_F(NvrtcTest, EveryKernelCompilesForEverySetOfFeatures) {
  std::vector<Features> sets(std::begin(kVariants), std::end(kVariants));
  sets.push_back(Features{});
  for (const KernelTemplate* kernel : kKernels) {
    for (const Features features : sets) {
      const auto compiled = nvrtc_->compile(*kernel, features, 90);
      ASSERT_TRUE(compiled) << kernel->name << " " << features.bits << ": "
                            << compiled.error().message;
      EXPECT_TRUE(
          compiled->code.starts_with("\x7f"
                                     "ELF"));
      EXPECT_NE(compiled->code.find(compiled->symbol), std::string::npos);
    }
  }
}

TEST_F(NvrtcTest, WhatASceneDoesNotNeedIsNotInItsCode) {
  const auto small = nvrtc_->compile(kTraceKernel, Features{}.with(Feature::kEnvironment), 90);
  const auto all = nvrtc_->compile(kTraceKernel, kAllFeatures, 90);
  ASSERT_TRUE(small && all);
  EXPECT_LT(small->code.size(), all->code.size());
  EXPECT_NE(small->symbol, all->symbol);
}

TEST_F(NvrtcTest, AnArchitectureThatItDoesNotKnowIsUnsupported) {
  const auto compiled = nvrtc_->compile(kTraceKernel, Features{}, 10);
  ASSERT_FALSE(compiled);
  EXPECT_EQ(compiled.error().code, ErrorCode::kUnsupported);
}

TEST_F(NvrtcTest, ASourceThatIsWrongSaysWhere) {
  KernelTemplate broken = kTraceKernel;
  broken.header = "renderd/engine/no_such.cuh";
  const auto compiled = nvrtc_->compile(broken, Features{}, 90);
  ASSERT_FALSE(compiled);
  EXPECT_EQ(compiled.error().code, ErrorCode::kInternal);
  EXPECT_NE(compiled.error().message.find("no_such.cuh"), std::string::npos);
}

TEST(KernelSources, HoldTheHeadersAsTheyAre) {
  bool found = false;
  for (const KernelSourceFile& file : kernel_sources()) {
    const std::string_view name(file.name), text(file.text);
    EXPECT_FALSE(name.starts_with("/")) << "a path of the machine that built it";
    EXPECT_TRUE(text.find("#pragma once") != std::string_view::npos) << name;
    if (name == "renderd/engine/cuda_trace.cuh") {
      found = true;
      EXPECT_NE(text.find("trace_kernel(const __grid_constant__"), std::string_view::npos);
      EXPECT_TRUE(text.ends_with("}  // namespace diaphane::render::cuda\n"));
    }
  }
  EXPECT_TRUE(found);
}

TEST(KernelRecipe, DependsOnTheArchitecture) {
  EXPECT_EQ(Nvrtc::recipe(90), Nvrtc::recipe(90));
  EXPECT_NE(Nvrtc::recipe(90), Nvrtc::recipe(100));
}

}  // namespace
}  // namespace diaphane::render::cuda
