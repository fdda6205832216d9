// Compares the denoiser on the device with that of the host, on the same film and guides.
#include "renderd/engine/cuda/denoise.h"

#include <cmath>
#include <random>

#include "renderd/engine/cpu/denoise.h"
#include "renderd/engine/cuda/film.h"
#include "tests/support/renderd/test_device.h"
#include "tests/support/renderd/test_kernels.h"

namespace diaphane::render::cuda {
namespace {

constexpr Canvas kCanvas{171, 94};  // not a multiple of a block or a tile
constexpr std::size_t kPixels = 171 * 94;
constexpr float kVoxel = 1.5f;

/// Noise over a picture with edges in film and guides, with some dropped samples, a slice and
/// background.
class CudaDenoiseTest : public CudaTest {
 protected:
  void make(std::uint32_t samples) {
    samples_ = samples;
    sum_.assign(3 * kPixels, 0);
    difference_.assign(3 * kPixels, 0);
    state_.assign(kPixels, 0);
    guides_.assign(kPixels, PackedGuides{});
    std::mt19937_64 random(samples);
    std::exponential_distribution<float> noise(1);
    std::vector<PixelBatch> batches(kPixels);
    for (std::size_t i = 0; i < kPixels; ++i) {
      const std::size_t x = i % kCanvas.width, y = i / kCanvas.width;
      const bool seen = (x - 85) * (x - 85) + (y - 47) * (y - 47) < 42 * 42 || x < 30;
      const bool slice = x > 120 && y < 30;
      const float level = x + y < 120 ? 0.1f : 0.6f;
      for (std::uint32_t s = 0; s < samples; ++s) {
        const float n = noise(random);
        const float r = random() % 200 == 0 ? std::numeric_limits<float>::quiet_NaN() : level * n;
        batches[i].add({r, 0.7f * r, 0.4f * noise(random) * level}, seen, s, slice);
      }
      fold({sum_.data(), difference_.data(), state_.data()}, i, batches[i]);
      if (!seen) continue;
      const float depth = 100.0f + 0.3f * static_cast<float>(x);
      guides_[i] = pack(x + y < 120 ? Guides{1, depth, {0.8f, 0.7f, 0.6f}, {0, 0.6f, 0.8f}}
                                    : Guides{0.7f, 0.7f * depth, {0.2f, 0.3f, 0.1f}, {0.7f, 0, 0}});
    }
    stream_ = *Stream::make();
    film_ = *CudaFilm::make(kCanvas);
    ASSERT_TRUE(film_.keep_guides(true));
    ASSERT_TRUE(film_.clear(stream_.get()));
    auto device = DeviceBuffer<PixelBatch>::of(kPixels);
    ASSERT_TRUE(device);
    ASSERT_TRUE(upload(*device, batches.data(), kPixels, stream_.get()));
    ASSERT_EQ(add_batches(film_.target(), device->data(), kPixels, stream_.get()), cudaSuccess);
    film_.done(film_.next(samples, samples), kCanvas.height);
    ASSERT_EQ(film_.samples(), samples);
    ASSERT_EQ(cudaMemcpyAsync(film_.target().guides, guides_.data(), kPixels * sizeof(PackedGuides),
                              cudaMemcpyHostToDevice, stream_.get()),
              cudaSuccess);
    ASSERT_EQ(cudaStreamSynchronize(stream_.get()), cudaSuccess);
  }
  std::vector<float> on_device() {
    std::vector<float> picture(3 * kPixels);
    EXPECT_TRUE(film_.radiance_denoised(denoiser_, kVoxel, kFade, picture.data(), stream_.get()));
    return picture;
  }
  std::vector<float> on_host() {
    ThreadPool pool(2);
    RendererThreads threads(pool);
    const ConstFilmView view{sum_.data(), difference_.data(), state_.data()};
    WhiteHistogram histogram;
    count_white(view, 0, kPixels, samples_, histogram);
    white_ = white_from_histogram(histogram);
    return denoise(threads, {view, guides_.data(), kCanvas, samples_, white_, kVoxel, kFade});
  }

  static constexpr float kFade = 0.9f;
  std::uint32_t samples_ = 0;
  float white_ = 1;
  std::vector<double> sum_;
  std::vector<float> difference_;
  std::vector<std::uint32_t> state_;
  std::vector<PackedGuides> guides_;
  Stream stream_;
  CudaFilm film_;
  CudaDenoiser denoiser_;
};

/// Weights near 0 differ by rounding, but never by more than a quarter of a display level.
TEST_F(CudaDenoiseTest, ImageMatchesTheHost) {
  if (!engine_) GTEST_SKIP();
  for (const std::uint32_t samples : {1u, 2u, 5u, 16u}) {
    ASSERT_NO_FATAL_FAILURE(make(samples));
    const auto host = on_host(), device = on_device();
    double moved = 0;
    for (std::size_t i = 0; i < host.size(); ++i) {
      ASSERT_NEAR(device[i] / white_, host[i] / white_, 1e-3) << samples << ", number " << i;
      const Float3 raw =
          estimate_of({sum_.data(), difference_.data(), state_.data()}, i / 3, samples).mean;
      moved += std::abs(raw[static_cast<int>(i % 3)] - host[i]);
    }
    EXPECT_GT(moved / static_cast<double>(host.size()), 1e-3) << "nothing was smoothed";
    EXPECT_GT(denoiser_.last_milliseconds(), 0);
  }
}

TEST_F(CudaDenoiseTest, IsDeterministicAndKeepsSlicePixels) {
  if (!engine_) GTEST_SKIP();
  ASSERT_NO_FATAL_FAILURE(make(3));
  const auto first = on_device();
  EXPECT_EQ(on_device(), first);
  std::vector<float> raw(3 * kPixels);
  ASSERT_TRUE(film_.radiance(raw.data(), stream_.get()));
  std::size_t slices = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    if ((state_[i] & kShowsSlice) == 0) continue;
    ++slices;
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(first[3 * i + c], raw[3 * i + c]);
  }
  EXPECT_GT(slices, 1000u);
}

/// The kernel records the same guides as the CPU engine, whose rays are the same. The test compares
/// their effect: the errors of both denoised pictures against a converged one are similar.
TEST_F(CudaDenoiseTest, DenoisesAsWellAsTheCpuEngine) {
  if (!engine_) GTEST_SKIP();
  const auto volume = lumpy_volume(40, 30, 25);
  const auto scene = full_scene();
  const Canvas canvas{96, 64};
  const auto error_of = [&](Engine& engine, std::uint32_t samples, bool smooth,
                            const std::vector<float>& truth) {
    // Tracking is used, because pictures of the exact walk leave little to denoise.
    auto one = engine.renderer(*engine.load(volume), 7, 0, {.walk = Walk::kTracking});
    EXPECT_TRUE(one);
    (*one)->prepare_denoising(true);
    EXPECT_TRUE(render_all(**one, scene, canvas, samples));
    PictureRgbF picture;
    if (smooth) {
      EXPECT_EQ((*one)->radiance_denoised(picture), true);
    } else {
      EXPECT_TRUE((*one)->radiance(picture));
    }
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += std::pow(static_cast<double>(picture.pixels[i] - truth[i]), 2);
    }
    return std::sqrt(sum / static_cast<double>(truth.size()));
  };
  auto reference = engine_->renderer(*engine_->load(volume), 1000, 0);
  ASSERT_TRUE(reference);
  ASSERT_TRUE(render_all(**reference, scene, canvas, 4096));
  const auto truth = radiance_of(**reference);
  const auto cpu = make_engine(EngineChoice::kCpu, 0);
  ASSERT_TRUE(cpu);
  for (const std::uint32_t samples : {1u, 4u, 16u}) {
    const double raw = error_of(*engine_, samples, false, truth);
    const double here = error_of(*engine_, samples, true, truth);
    const double there = error_of(**cpu, samples, true, truth);
    EXPECT_LT(here, 0.8 * raw) << samples;
    EXPECT_NEAR(here / there, 1, 0.15) << samples;
  }
}

}  // namespace
}  // namespace diaphane::render::cuda
