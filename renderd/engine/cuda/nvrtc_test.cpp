// Verifies that the kernels compile at run time. Needs the compiler's library, but no device.
#include "renderd/engine/cuda/nvrtc.h"

#include <gtest/gtest.h>

#include <span>
#include <string_view>

#include "renderd/engine/cuda/exact.h"
#include "renderd/engine/cuda/kernel_sources.h"
#include "renderd/engine/cuda/trace.h"
#include "renderd/kernel/variants.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render::cuda {
namespace {

/// All kernels that an engine may launch. Add new kernels here.
const KernelTemplate* const kKernels[] = {&kTraceKernel, &kExactCamera, &kExactLight,
                                          &kExactIndirect};

class NvrtcTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto nvrtc = Nvrtc::load();
    if (!nvrtc) GTEST_SKIP() << nvrtc.error().message;
    nvrtc_ = *nvrtc;
  }
  std::shared_ptr<const Nvrtc> nvrtc_;
};

/// Each compilation takes a second or more, so only three feature sets are compiled: none, those of
/// a typical scene, and, in the nightly lane, all. The build compiles the same sources with all
/// features. The code does not contain what a scene does not need.
TEST_F(NvrtcTest, CompilesEveryKernelSmallerWithFewerFeatures) {
  const Features sets[] = {Features{}, kVariants[1], kAllFeatures};
  for (const KernelTemplate* kernel : kKernels) {
    std::size_t size = 0;
    std::string symbol;
    for (const Features features :
         std::span(sets).first(test::gate_or_nightly(std::size_t{2}, std::size_t{3}))) {
      const auto compiled = nvrtc_->compile(*kernel, features, 90);
      ASSERT_TRUE(compiled) << kernel->name << " " << features.bits << ": "
                            << compiled.error().message;
      EXPECT_TRUE(
          compiled->code.starts_with("\x7f"
                                     "ELF"));
      EXPECT_NE(compiled->code.find(compiled->symbol), std::string::npos);
      EXPECT_NE(compiled->symbol, symbol);
      EXPECT_GT(compiled->code.size(), size);
      size = compiled->code.size();
      symbol = compiled->symbol;
    }
  }
}

TEST_F(NvrtcTest, ReportsUnknownArchitectureAsUnsupported) {
  const auto compiled = nvrtc_->compile(kTraceKernel, Features{}, 10);
  ASSERT_FALSE(compiled);
  EXPECT_EQ(compiled.error().code, ErrorCode::kUnsupported);
}

TEST_F(NvrtcTest, CompileErrorNamesTheFile) {
  KernelTemplate broken = kTraceKernel;
  broken.header = "renderd/engine/cuda/no_such.cuh";
  const auto compiled = nvrtc_->compile(broken, Features{}, 90);
  ASSERT_FALSE(compiled);
  EXPECT_EQ(compiled.error().code, ErrorCode::kInternal);
  EXPECT_NE(compiled.error().message.find("no_such.cuh"), std::string::npos);
}

TEST(KernelSources, ContainTheUnchangedHeaders) {
  bool found = false;
  for (const KernelSourceFile& file : kernel_sources()) {
    const std::string_view name(file.name), text(file.text);
    EXPECT_FALSE(name.starts_with("/")) << "contains a path of the build machine";
    EXPECT_TRUE(text.find("#pragma once") != std::string_view::npos) << name;
    if (name == "renderd/engine/cuda/trace.cuh") {
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
