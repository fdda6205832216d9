// Tests of the CUDA engine through the Engine interface. They need a device and are skipped without
// one.
#include "renderd/engine/cuda/engine.h"

#include <cuda_runtime_api.h>

#include <cmath>
#include <cstdlib>
#include <thread>

#include "renderd/engine/cuda/error.h"
#include "tests/support/renderd/test_device.h"
#include "tests/support/renderd/test_kernels.h"

namespace diaphane::render::cuda {
namespace {

constexpr Canvas kCanvas{96, 70};

class CudaEngineTest : public CudaTest {
 protected:
  void SetUp() override {
    CudaTest::SetUp();
    if (!engine_) return;
    auto loaded = engine_->load(lumpy_volume(40, 30, 25));
    ASSERT_TRUE(loaded) << loaded.error().message;
    volume_ = *loaded;
  }
  std::vector<float> rendered(std::uint32_t samples, std::uint64_t seed = 1) {
    auto one = renderer(volume_, seed);
    const auto done = render_all(*one, full_scene(), kCanvas, samples);
    EXPECT_TRUE(done) << done.error().message;
    return radiance_of(*one);
  }
  std::shared_ptr<const DeviceVolume> volume_;
};

TEST_F(CudaEngineTest, SameSeedGivesTheSameBits) {
  const auto picture = rendered(40);
  EXPECT_EQ(picture, rendered(40));
  EXPECT_NE(picture, rendered(40, 2));
}

TEST_F(CudaEngineTest, StoppedBatchResumesWithTheSameBits) {
  auto one = renderer(volume_);
  ASSERT_TRUE(one->set_scene(full_scene(), {512, 512}));
  ASSERT_TRUE(render_all(*one, full_scene(), {512, 512}, 40));
  const auto whole = radiance_of(*one);

  ASSERT_TRUE(one->set_scene(full_scene(), {512, 512}));
  std::uint32_t done = 0;
  int calls = 0;
  while (done < 40 && ++calls < 10000) {
    int asked = 0;
    const auto batch = one->render(40 - done, [&] { return ++asked > 2; });
    ASSERT_TRUE(batch) << batch.error().message;
    done += batch->samples;
    ASSERT_EQ(one->progress().samples, done);
  }
  EXPECT_EQ(done, 40u);
  EXPECT_GT(calls, 3) << "nothing was stopped";
  EXPECT_EQ(whole, radiance_of(*one));
}

TEST_F(CudaEngineTest, BatchStoppedBeforeItStartsAddsNothing) {
  auto one = renderer(volume_);
  ASSERT_TRUE(one->set_scene(full_scene(), kCanvas));
  const auto batch = one->render(8, [] { return true; });
  ASSERT_TRUE(batch);
  EXPECT_EQ(batch->samples, 0u);
  EXPECT_EQ(one->progress().samples, 0u);
  EXPECT_TRUE(std::isinf(one->progress().error));
}

TEST_F(CudaEngineTest, SessionsThatShareAVolumeAreIndependent) {
  constexpr int kSessions = 8;
  std::vector<std::vector<float>> alone, together(kSessions);
  for (int i = 0; i < kSessions; ++i) alone.push_back(rendered(32, 10 + i));
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kSessions; ++i) {
      threads.emplace_back([&, i] { together[i] = rendered(32, 10 + i); });
    }
  }
  EXPECT_EQ(alone, together);
}

TEST_F(CudaEngineTest, ErrorFallsWithTheSquareRootOfTheSamples) {
  auto one = renderer(volume_);
  ASSERT_TRUE(render_all(*one, full_scene(), kCanvas, 64));
  const double before = one->progress().error;
  ASSERT_TRUE(one->render(64 * 15, [] { return false; }));
  // There are 16 times as many samples. Each estimate over 6720 x 3 numbers is within a few percent
  // of its mean.
  EXPECT_NEAR(before / one->progress().error, 4, 0.5);
}

TEST_F(CudaEngineTest, RefusesInvalidSceneAndKeepsTheImage) {
  auto one = renderer(volume_);
  ASSERT_TRUE(render_all(*one, full_scene(), kCanvas, 4));
  const auto before = radiance_of(*one);
  auto bad = full_scene();
  bad.mutable_camera()->mutable_eye()->set_x(std::nan(""));
  const auto refused = one->set_scene(bad, kCanvas);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(refused.error().field, "camera.eye.x");
  EXPECT_FALSE(one->set_scene(full_scene(), {0, 5}));
  EXPECT_EQ(one->progress().samples, 4u);
  EXPECT_EQ(before, radiance_of(*one));
}

TEST_F(CudaEngineTest, NewSceneRendersLikeTheFirst) {
  auto used = renderer(volume_);
  auto other = full_scene();
  other.mutable_transfer_function()->mutable_channels()->DeleteSubrange(1, 1);
  other.mutable_lights()->DeleteSubrange(0, 2);
  other.mutable_phase()->set_g(0);
  ASSERT_TRUE(render_all(*used, other, {33, 21}, 8));
  EXPECT_EQ(used->features(), (std::vector<std::string>{"environment", "curves"}));
  ASSERT_TRUE(render_all(*used, full_scene(), kCanvas, 24));
  EXPECT_EQ(radiance_of(*used), rendered(24));
}

/// Allocates all of the device's memory except `spare` bytes.
class FullDevice {
 public:
  explicit FullDevice(std::size_t spare) {
    for (std::size_t piece = std::size_t{1} << 34; piece >= (1u << 20); piece /= 2) {
      void* held = nullptr;
      while (free_bytes() > piece + spare && cudaMalloc(&held, piece) == cudaSuccess) {
        held_.push_back(held);
      }
      cudaGetLastError();
    }
  }
  ~FullDevice() {
    for (void* held : held_) cudaFree(held);
  }
  static std::size_t free_bytes() {
    std::size_t free = 0, total = 0;
    EXPECT_EQ(cudaMemGetInfo(&free, &total), cudaSuccess);
    return free;
  }

 private:
  std::vector<void*> held_;
};

TEST_F(CudaEngineTest, OutOfMemoryKeepsTheImage) {
  auto one = renderer(volume_);
  ASSERT_TRUE(render_all(*one, full_scene(), kCanvas, 16));
  const auto before = radiance_of(*one);
  const std::size_t free_before = FullDevice::free_bytes();
  {
    const FullDevice full(64u << 20);
    const auto volume = engine_->load(constant_volume(512, 7));  // 256 MB
    ASSERT_FALSE(volume);
    EXPECT_EQ(volume.error().code, ErrorCode::kOutOfMemory);
    const auto scene = one->set_scene(full_scene(), {8192, 8192});  // 2.7 GB
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().code, ErrorCode::kOutOfMemory);
    EXPECT_EQ(before, radiance_of(*one));
    EXPECT_EQ(one->progress().samples, 16u);
  }
  EXPECT_NEAR(static_cast<double>(FullDevice::free_bytes()), static_cast<double>(free_before),
              32 << 20);
  ASSERT_TRUE(one->render(8, [] { return false; }));
  EXPECT_EQ(one->progress().samples, 24u);
  EXPECT_TRUE(engine_->load(constant_volume(512, 7)));
}

TEST_F(CudaEngineTest, LowMemoryGivesTheSameBits) {
  // The working memory of the exact walk for 640 x 480 would take 92 MB.
  const Canvas canvas{640, 480};
  std::vector<float> tight;
  {
    auto one = renderer(volume_);
    ASSERT_TRUE(render_all(*one, full_scene(), {8, 8}, 1)) << "its kernels are loaded";
    const FullDevice full(48u << 20);
    const auto done = render_all(*one, full_scene(), canvas, 3);
    ASSERT_TRUE(done) << done.error().message;
    tight = radiance_of(*one);
  }
  auto other = renderer(volume_);
  ASSERT_TRUE(render_all(*other, full_scene(), canvas, 3));
  EXPECT_EQ(tight, radiance_of(*other));
}

TEST_F(CudaEngineTest, TransmissionFollowsBeerLambert) {
  // With 32 mm of constant extinction, a sample is 1 with probability exp(-depth), otherwise 0. The
  // binomial distribution is tested to a significance of 1e-5 over all depths.
  constexpr std::uint32_t kSamples = 256;
  constexpr Canvas kSquare{64, 64};
  const std::vector<double> depths{1e-4, 1e-2, 0.3, 1, 3, 8};
  const double critical = critical_t(sidak(1e-5, depths.size()), 1e9);
  auto loaded = engine_->load(constant_volume(32, 1234));
  ASSERT_TRUE(loaded);
  auto one = renderer(*loaded);
  for (const double depth : depths) {
    const auto done = render_all(*one, transmittance_scene(depth / 32), kSquare, kSamples);
    ASSERT_TRUE(done) << done.error().message;
    const auto pixels = radiance_of(*one);
    double sum = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 3) sum += static_cast<double>(pixels[i]);
    const double count = static_cast<double>(pixels.size() / 3) * kSamples;
    const double p = std::exp(-depth);
    const double z = (sum * kSamples - count * p) / std::sqrt(count * p * (1 - p));
    EXPECT_LT(std::abs(z), critical) << "depth " << depth;
  }
}

/// Breaks the context by a kernel that writes to a null pointer. The exit code is 0 if every later
/// call reports that the device is lost.
[[noreturn]] void break_the_device() {
  auto engine = make_cuda_engine();
  auto volume = (*engine)->load(lumpy_volume(8, 8, 8));
  auto one = (*engine)->renderer(*volume, 1, 0);
  const auto begun = render_all(**one, full_scene(), kCanvas, 4);
  add_batches(TraceTarget{{nullptr, nullptr, nullptr}, nullptr}, nullptr, 1, nullptr);
  cudaDeviceSynchronize();
  const auto lost = [](const auto& result) {
    return !result && result.error().code == ErrorCode::kDeviceLost;
  };
  PictureRgb8 picture;
  const bool said =
      begun && lost((*one)->render(1, [] { return false; })) && lost((*one)->display(picture)) &&
      lost((*one)->set_scene(full_scene(), kCanvas)) &&
      lost((*engine)->load(lumpy_volume(8, 8, 8))) && lost((*engine)->renderer(*volume, 1, 0));
  std::_Exit(said ? 0 : 1);
}

TEST_F(CudaEngineTest, EveryCallReportsALostDevice) {
  // The test needs a new process, because a broken context lasts as long as its process.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(break_the_device(), ::testing::ExitedWithCode(0), "");
}

TEST(CudaError, MapsToErrorCodes) {
  EXPECT_EQ(error_of(cudaErrorMemoryAllocation).code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(error_of(cudaErrorNoDevice).code, ErrorCode::kUnavailable);
  EXPECT_EQ(error_of(cudaErrorInsufficientDriver).code, ErrorCode::kUnavailable);
  EXPECT_EQ(error_of(cudaErrorIllegalAddress).code, ErrorCode::kDeviceLost);
  EXPECT_EQ(error_of(cudaErrorLaunchFailure).code, ErrorCode::kDeviceLost);
}

/// Like share_test.cpp for the CPU: parts of one sequence and bands of rows that are taken from one
/// film and merged into another give the picture of one device.
TEST_F(CudaEngineTest, PartsAndBandsReproduceTheSingleDeviceImage) {
  const auto alone = rendered(8);
  for (const bool tiles : {false, true}) {
    auto merged = renderer(volume_);
    ASSERT_TRUE(merged->set_scene(full_scene(), kCanvas));
    auto other = renderer(volume_);
    ASSERT_TRUE(other->set_scene(full_scene(), kCanvas));
    if (tiles) {
      ASSERT_TRUE(merged->set_share({.first_row = 0, .last_row = 32}));
      ASSERT_TRUE(other->set_share({.first_row = 32}));
    } else {
      ASSERT_TRUE(merged->set_share({.part = 0, .parts = 2}));
      ASSERT_TRUE(other->set_share({.part = 1, .parts = 2}));
    }
    const std::uint32_t each = tiles ? 8 : 4;
    const auto never = [] { return false; };
    ASSERT_TRUE(merged->render(each, never));
    for (const std::uint32_t samples : {2u, each - 2}) {
      ASSERT_TRUE(other->render(samples, never));
      FilmPart part;
      const auto taken = samples == 2 ? other->take_film(part) : other->take_film_here(part);
      ASSERT_TRUE(taken && *taken);
      ASSERT_EQ(part.samples, samples);
      ASSERT_TRUE(merged->merge_film(part));
    }
    ASSERT_EQ(merged->progress().samples, 8u);
    const auto picture = radiance_of(*merged);
    ASSERT_EQ(picture.size(), alone.size());
    for (std::size_t i = 0; i < picture.size(); ++i) {
      // Packed means are rounded, and the sums have another order.
      ASSERT_NEAR(picture[i], alone[i], 0x1p-10f * alone[i] + 1e-6f) << tiles << " " << i;
    }
    // Merged samples remain when another share begins.
    ASSERT_TRUE(merged->set_share({.sequence = 1}));
    ASSERT_TRUE(merged->render(2, never));
    EXPECT_EQ(merged->progress().samples, 10u);
  }
}

/// A band brings its guides through host memory as well as in device memory.
TEST_F(CudaEngineTest, BandsBringTheGuidesOfTheDenoiser) {
  const auto never = [] { return false; };
  const auto prepared = [&](bool guided, const Share& share) {
    auto made = renderer(volume_);
    made->prepare_denoising(guided);
    EXPECT_TRUE(made->set_scene(full_scene(), kCanvas));
    EXPECT_TRUE(made->set_share(share));
    EXPECT_TRUE(made->render(4, never));
    return made;
  };
  const auto smoothed = [](FrameRenderer& one) {
    PictureRgbF picture;
    EXPECT_EQ(one.radiance_denoised(picture), true);
    return picture.pixels;
  };
  const auto alone = smoothed(*prepared(true, {}));
  const auto difference = [&](bool guided, bool here) {
    const auto merged = prepared(true, {.first_row = 0, .last_row = 32});
    const auto other = prepared(guided, {.first_row = 32});
    FilmPart part;
    const auto taken = here ? other->take_film_here(part) : other->take_film(part);
    EXPECT_TRUE(taken && *taken);
    EXPECT_TRUE(merged->merge_film(part));
    const auto picture = smoothed(*merged);
    double most = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) {
      const double expected = static_cast<double>(alone[i]);
      most =
          std::max(most, std::abs(static_cast<double>(picture[i]) - expected) / (expected + 1e-3));
    }
    return most;
  };
  for (const bool here : {false, true}) {
    // The filter weighs by the noise, of which parts keep 2 bits (PackedPixel).
    EXPECT_LT(difference(true, here), 0.05) << here;
    EXPECT_GT(difference(false, here), 0.05) << "a band without guides is not smoothed";
  }
}

}  // namespace
}  // namespace diaphane::render::cuda
