// Tests which kernel renders a picture, and that the choice does not change the estimate. Needs a
// device.
#include "renderd/engine/cuda/variants.h"

#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "renderd/engine/cuda/engine.h"
#include "renderd/engine/cuda/nvrtc.h"
#include "tests/support/renderd/test_device.h"

namespace diaphane::render::cuda {
namespace {

namespace fs = std::filesystem;
constexpr Canvas kCanvas{96, 70};
const std::function<bool()> kNever = [] { return false; };

class CudaVariantsTest : public CudaTest {
 protected:
  CudaVariantsTest() {
    std::string pattern = (fs::temp_directory_path() / "kernels-XXXXXX").string();
    directory_ = ::mkdtemp(pattern.data());
  }
  ~CudaVariantsTest() override { fs::remove_all(directory_); }
  void SetUp() override {
    CudaTest::SetUp();
    if (engine_ && !Nvrtc::load()) GTEST_SKIP() << Nvrtc::load().error().message;
  }

  /// Makes a separate engine, which has no kernel in memory.
  std::unique_ptr<Engine> engine(KernelChoice choice) {
    EngineOptions options;
    options.kernels = choice;
    options.kernel_cache = directory_;
    auto made = make_cuda_engine(options);
    EXPECT_TRUE(made) << made.error().message;
    return made ? std::move(*made) : nullptr;
  }
  static std::unique_ptr<FrameRenderer> renderer_of(Engine& engine, std::uint64_t seed = 1) {
    auto volume = engine.load(lumpy_volume(40, 30, 25));
    EXPECT_TRUE(volume);
    auto made = engine.renderer(*volume, seed, 0);
    EXPECT_TRUE(made);
    return std::move(*made);
  }
  /// A scene with the sky as its only light, which has fewer features than any other test scene.
  static diaphane::v1::Scene sky_scene() {
    auto scene = full_scene();
    scene.mutable_lights()->DeleteSubrange(0, 2);
    scene.mutable_phase()->set_g(0);
    return scene;
  }

  std::string directory_;
};

TEST_F(CudaVariantsTest, CompilesExactlyTheFeaturesOfTheScene) {
  const auto exact = engine(KernelChoice::kExact);
  const auto one = renderer_of(*exact);
  ASSERT_TRUE(one->set_scene(sky_scene(), kCanvas));
  const KernelReport report = one->report();
  EXPECT_EQ(report.origin, KernelOrigin::kForThisScene);
  EXPECT_EQ(report.compiled_in, one->features());
  EXPECT_EQ(report.compiled_in.size() + report.left_out.size(), std::size_t{kFeatureCount});
  EXPECT_GT(report.registers, 0);
  EXPECT_GT(report.compile_milliseconds, 0);
  EXPECT_FALSE(report.from_cache);
  EXPECT_EQ(report.note, "");
}

TEST_F(CudaVariantsTest, CachedKernelGivesTheSameBits) {
  std::vector<float> first;
  double cold = 0;
  for (const bool again : {false, true}) {
    const auto exact = engine(KernelChoice::kExact);
    const auto one = renderer_of(*exact);
    ASSERT_TRUE(render_all(*one, full_scene(), kCanvas, 40));
    EXPECT_EQ(one->report().from_cache, again);
    if (!again) {
      first = radiance_of(*one);
      cold = one->report().compile_milliseconds;
      continue;
    }
    EXPECT_EQ(first, radiance_of(*one));
    RecordProperty("cold_ms", std::to_string(cold));
    RecordProperty("disk_ms", std::to_string(one->report().compile_milliseconds));
    EXPECT_LT(one->report().compile_milliseconds, cold);
  }
}

TEST_F(CudaVariantsTest, RecompilesDamagedCachedKernel) {
  {
    const auto exact = engine(KernelChoice::kExact);
    ASSERT_TRUE(renderer_of(*exact)->set_scene(sky_scene(), kCanvas));
  }
  for (const auto& entry : fs::directory_iterator(directory_)) {
    std::ofstream(entry.path(), std::ios::binary) << "damaged";
  }
  const auto exact = engine(KernelChoice::kExact);
  const auto one = renderer_of(*exact);
  ASSERT_TRUE(one->set_scene(sky_scene(), kCanvas));
  EXPECT_EQ(one->report().origin, KernelOrigin::kForThisScene);
  EXPECT_FALSE(one->report().from_cache);
}

TEST_F(CudaVariantsTest, ImageKeepsItsFirstKernel) {
  const auto server = engine(KernelChoice::kStandIn);
  const auto one = renderer_of(*server);
  ASSERT_TRUE(one->set_scene(full_scene(), kCanvas));
  ASSERT_TRUE(one->render(8, kNever));
  const KernelOrigin begun_with = one->report().origin;
  ASSERT_NE(begun_with, KernelOrigin::kForThisScene) << "compiled within a millisecond?";
  // Other renderers set the same scene until its own kernel is ready.
  for (int i = 0; i < 600; ++i) {
    const auto other = renderer_of(*server);
    ASSERT_TRUE(other->set_scene(full_scene(), kCanvas));
    if (other->report().origin == KernelOrigin::kForThisScene) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_TRUE(one->render(32, kNever));
  EXPECT_EQ(one->report().origin, begun_with);
  // The stand-in must render the whole picture, as if there were no other kernel.
  const auto general = engine(KernelChoice::kAheadOfTime);
  const auto reference = renderer_of(*general);
  ASSERT_TRUE(reference->set_scene(full_scene(), kCanvas));
  ASSERT_TRUE(reference->render(8, kNever));
  ASSERT_TRUE(reference->render(32, kNever));
  EXPECT_EQ(radiance_of(*one), radiance_of(*reference));
  // A new picture uses the new kernel.
  ASSERT_TRUE(one->set_scene(full_scene(), kCanvas));
  EXPECT_EQ(one->report().origin, KernelOrigin::kForThisScene);
}

/// Welch's t-test of the mean of each pixel over runs with independent seeds. Four choices of
/// kernels are compared with the scene's own kernel, at a total significance of 1e-4.
TEST_F(CudaVariantsTest, EveryKernelHasTheSameMean) {
  constexpr int kRuns = 40;
  constexpr Canvas kSmall{12, 10};
  const auto moments = [&](KernelChoice choice, const diaphane::v1::Scene& scene,
                           std::uint64_t seed) {
    const auto its = engine(choice);
    std::vector<double> sum(3 * kSmall.width * kSmall.height), squares(sum.size());
    for (int run = 0; run < kRuns; ++run) {
      const auto one = renderer_of(*its, seed + static_cast<std::uint64_t>(run));
      EXPECT_TRUE(render_all(*one, scene, kSmall, 64));
      const auto picture = radiance_of(*one);
      for (std::size_t i = 0; i < picture.size(); ++i) {
        const double x = static_cast<double>(picture[i]);
        sum[i] += x;
        squares[i] += x * x;
      }
    }
    return std::pair(sum, squares);
  };
  for (const auto& scene : {full_scene(), sky_scene()}) {
    const auto [sum, squares] = moments(KernelChoice::kExact, scene, 100);
    for (const KernelChoice choice : {KernelChoice::kAheadOfTime, KernelChoice::kGeneral}) {
      const auto [other_sum, other_squares] = moments(choice, scene, 5000);
      const double limit = critical_t(sidak(1e-4, 4 * sum.size()), 2 * kRuns - 2);
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const auto variance = [](double s, double q) {
          return (q - s * s / kRuns) / (kRuns - 1) / kRuns;
        };
        const double v = variance(sum[i], squares[i]) + variance(other_sum[i], other_squares[i]);
        const double difference = (sum[i] - other_sum[i]) / kRuns;
        if (v < 1e-16) {
          EXPECT_NEAR(difference, 0, 1e-5) << i;
        } else {
          EXPECT_LT(std::abs(difference) / std::sqrt(v), limit) << i;
        }
      }
    }
  }
}

TEST_F(CudaVariantsTest, TheGeneralKernelHasAllFeatures) {
  const auto general = engine(KernelChoice::kGeneral);
  const auto one = renderer_of(*general);
  ASSERT_TRUE(one->set_scene(sky_scene(), kCanvas));
  EXPECT_EQ(one->report().origin, KernelOrigin::kGeneral);
  EXPECT_TRUE(one->report().left_out.empty());
}

TEST_F(CudaVariantsTest, LeanMemoryModeAddsAtMostFivePercentToTheVolume) {
  EngineOptions options;
  options.lean_memory = true;
  options.kernels = KernelChoice::kGeneral;
  auto lean = make_cuda_engine(options);
  ASSERT_TRUE(lean);
  auto volume = (*lean)->load(lumpy_volume(256, 256, 128));
  ASSERT_TRUE(volume);
  auto one = (*lean)->renderer(*volume, 1, 0);
  ASSERT_TRUE(one);
  ASSERT_TRUE(render_all(**one, full_scene(), kCanvas, 2));
  const KernelReport report = (*one)->report();
  EXPECT_LE(static_cast<double>(report.volume_bytes + report.acceleration_bytes),
            1.05 * 2 * 256 * 256 * 128);
}

}  // namespace
}  // namespace diaphane::render::cuda
