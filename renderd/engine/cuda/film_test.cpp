// Compares the kernels of the film with the functions of the host on the same numbers.
#include "renderd/engine/cuda/film.h"

#include <cstring>
#include <random>

#include "tests/support/renderd/test_device.h"
#include "tests/support/renderd/test_kernels.h"

namespace diaphane::render::cuda {
namespace {

constexpr Canvas kCanvas{75, 41};
constexpr std::size_t kPixels = 75 * 41;

/// Returns batches of several samples, of which some are dropped, and some pixels without matter.
std::vector<PixelBatch> random_batch(std::uint64_t seed, std::uint64_t first,
                                     std::uint32_t samples) {
  std::mt19937_64 random(seed);
  std::lognormal_distribution<float> radiance(0, 2);
  std::vector<PixelBatch> batch(kPixels);
  for (std::size_t i = 0; i < kPixels; ++i) {
    for (std::uint32_t s = 0; s < samples; ++s) {
      const bool broken = random() % 50 == 0;
      const float r = broken ? std::numeric_limits<float>::infinity() : radiance(random);
      batch[i].add({r, 0.5f * r, radiance(random)}, i % 3 != 0, first + s);
    }
  }
  return batch;
}

class CudaFilmTest : public CudaTest {
 protected:
  void SetUp() override {
    CudaTest::SetUp();
    if (!engine_) return;
    stream_ = *Stream::make();
    film_ = *CudaFilm::make(kCanvas);
    ASSERT_TRUE(film_.clear(stream_.get()));
    std::uint64_t first = 0;
    for (std::uint32_t samples : {1u, 16u, 7u}) {
      const auto batch = random_batch(first, first, samples);
      for (std::size_t i = 0; i < kPixels; ++i) {
        diaphane::render::fold({sum_.data(), difference_.data(), state_.data()}, i, batch[i]);
        dropped_ += batch[i].dropped_even + batch[i].dropped_odd;
      }
      auto device = DeviceBuffer<PixelBatch>::of(kPixels);
      ASSERT_TRUE(device);
      ASSERT_TRUE(upload(*device, batch.data(), kPixels, stream_.get()));
      ASSERT_EQ(add_batches(film_.target(), device->data(), kPixels, stream_.get()), cudaSuccess);
      film_.done(film_.next(first + samples, 100), kCanvas.height);
      ASSERT_EQ(film_.samples(), first + samples);
      first += samples;
    }
  }
  ConstFilmView host() const { return {sum_.data(), difference_.data(), state_.data()}; }

  Stream stream_;
  CudaFilm film_;
  std::uint64_t dropped_ = 0;
  std::vector<double> sum_ = std::vector<double>(3 * kPixels);
  std::vector<float> difference_ = std::vector<float>(3 * kPixels);
  std::vector<std::uint32_t> state_ = std::vector<std::uint32_t>(kPixels);
};

TEST_F(CudaFilmTest, DropsAndCountsNonFiniteSamples) {
  ASSERT_GT(dropped_, 0u);
  EXPECT_EQ(film_.dropped(stream_.get()), dropped_);
  std::vector<float> picture(3 * kPixels);
  ASSERT_TRUE(film_.radiance(picture.data(), stream_.get()));
  for (std::size_t i = 0; i < kPixels; ++i) {
    const Float3 mean = estimate_of(host(), i, film_.samples()).mean;
    ASSERT_FLOAT_EQ(picture[3 * i], mean.x);
    ASSERT_FLOAT_EQ(picture[3 * i + 1], mean.y);
    ASSERT_FLOAT_EQ(picture[3 * i + 2], mean.z);
  }
}

TEST_F(CudaFilmTest, ErrorMatchesTheHostThroughEitherCurve) {
  WhiteHistogram histogram;
  count_white(host(), 0, kPixels, film_.samples(), histogram);
  const float white = white_from_histogram(histogram);
  for (const ToneCurve curve : {ToneCurve::kLinear, ToneCurve::kFilmic}) {
    std::vector<TileError> tiles;
    for (std::uint32_t y = 0; y < (kCanvas.height + kTileSize - 1) / kTileSize; ++y) {
      for (std::uint32_t x = 0; x < (kCanvas.width + kTileSize - 1) / kTileSize; ++x) {
        tiles.push_back(tile_error(host(), kCanvas, x, y, film_.samples(), white, curve));
      }
    }
    const double expected = total_error(tiles, film_.samples());
    film_.set_curve(curve);
    const auto measured = film_.measure(true, stream_.get());
    ASSERT_TRUE(measured);
    EXPECT_NEAR(measured->error, expected, 1e-5 * expected);
    EXPECT_EQ(measured->mean, metering_of(histogram).mean);
  }
}

TEST_F(CudaFilmTest, ImageMatchesTheHostWithinOneLevel) {
  std::vector<std::uint8_t> picture(3 * kPixels);
  for (const ToneCurve curve : {ToneCurve::kLinear, ToneCurve::kFilmic}) {
    film_.set_curve(curve);
    ASSERT_TRUE(film_.display(0.25f, picture.data(), stream_.get()));
    std::size_t other = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const Float3 mean = estimate_of(host(), i, film_.samples()).mean;
      for (int c = 0; c < 3; ++c) {
        const int expected = to_display(mean[c], 0.25f, curve);
        ASSERT_NEAR(picture[3 * i + c], expected, 1);
        other += picture[3 * i + c] != expected;
      }
    }
    // Rounding makes a difference only for values within 1e-4 of the border between two levels.
    EXPECT_LT(other, 3 * kPixels / 500);
  }
}

TEST_F(CudaFilmTest, NormalizesEachRowByItsOwnSampleCount) {
  // One more batch of 5 samples is stopped after its first 16 rows.
  const auto batch = random_batch(77, film_.samples(), 5);
  constexpr std::size_t kAhead = 16 * kCanvas.width;
  auto device = DeviceBuffer<PixelBatch>::of(kAhead);
  ASSERT_TRUE(device);
  ASSERT_TRUE(upload(*device, batch.data(), kAhead, stream_.get()));
  ASSERT_EQ(add_batches(film_.target(), device->data(), kAhead, stream_.get()), cudaSuccess);
  for (std::size_t i = 0; i < kAhead; ++i) {
    diaphane::render::fold({sum_.data(), difference_.data(), state_.data()}, i, batch[i]);
  }
  film_.done(film_.next(film_.samples() + 5, 5), 16);
  EXPECT_EQ(film_.samples(), 24u);
  std::vector<float> picture(3 * kPixels);
  ASSERT_TRUE(film_.radiance(picture.data(), stream_.get()));
  for (std::size_t i = 0; i < kPixels; ++i) {
    ASSERT_FLOAT_EQ(picture[3 * i], estimate_of(host(), i, i < kAhead ? 29 : 24).mean.x) << i;
  }
}

TEST_F(CudaFilmTest, ImageIsTheSameInOneOrSeveralPieces) {
  // There are more pixels than radiance() computes at once.
  auto large = CudaFilm::make({1031, 700});
  ASSERT_TRUE(large);
  ASSERT_TRUE(large->clear(stream_.get()));
  std::vector<PixelBatch> batch(large->pixels());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    batch[i].add({static_cast<float>(i), 1, 0}, true, 0);
  }
  auto device = DeviceBuffer<PixelBatch>::of(batch.size());
  ASSERT_TRUE(device);
  ASSERT_TRUE(upload(*device, batch.data(), batch.size(), stream_.get()));
  ASSERT_EQ(add_batches(large->target(), device->data(), batch.size(), stream_.get()), cudaSuccess);
  large->done(large->next(1, 1), 700);
  std::vector<float> picture(3 * large->pixels());
  ASSERT_TRUE(large->radiance(picture.data(), stream_.get()));
  for (std::size_t i = 0; i < batch.size(); ++i) {
    ASSERT_EQ(picture[3 * i], static_cast<float>(i));
    ASSERT_EQ(picture[3 * i + 1], 1.0f);
  }
}

TEST_F(CudaFilmTest, LimitsFullHdSessionTo100Megabytes) {
  auto hd = CudaFilm::make({1920, 1080});
  ASSERT_TRUE(hd);
  ASSERT_TRUE(hd->clear(stream_.get()));
  std::vector<std::uint8_t> picture(3 * hd->pixels());
  ASSERT_TRUE(hd->display(1, picture.data(), stream_.get()));
  hd->done(hd->next(4, 4), 1080);
  ASSERT_TRUE(hd->measure(true, stream_.get()));
  EXPECT_LE(hd->device_bytes(), 92'000'000u) << "8 MB are for tables and cell bounds";
}

TEST_F(CudaFilmTest, LimitsFullHdSessionTo100MegabytesWithDenoising) {
  auto hd = CudaFilm::make({1920, 1080});
  ASSERT_TRUE(hd);
  ASSERT_TRUE(hd->keep_guides(true));
  ASSERT_TRUE(hd->clear(stream_.get()));
  hd->done(hd->next(2, 2), 1080);
  CudaDenoiser denoiser;
  std::vector<std::uint8_t> picture(3 * hd->pixels());
  ASSERT_TRUE(hd->measure(true, stream_.get()));
  ASSERT_TRUE(hd->display_denoised(denoiser, 1, 1, 1, picture.data(), stream_.get()));
  std::vector<float> radiance(3 * hd->pixels());
  ASSERT_TRUE(hd->radiance_denoised(denoiser, 1, 1, radiance.data(), stream_.get()));
  EXPECT_LE(hd->device_bytes(), 96'000'000u) << "4 MB are for tables and cell bounds";
  // Without guides, the displayed picture uses their memory.
  ASSERT_TRUE(hd->keep_guides(false));
  ASSERT_TRUE(hd->display(1, picture.data(), stream_.get()));
  EXPECT_LE(hd->device_bytes(), 96'000'000u);
}

/// A drag makes the picture smaller, and its end makes it larger again. The film must keep its
/// memory.
TEST_F(CudaFilmTest, ReusesItsMemoryForSmallerImages) {
  auto film = CudaFilm::make({64, 48});
  ASSERT_TRUE(film);
  ASSERT_TRUE(film->keep_guides(true));
  const std::uint64_t bytes = film->device_bytes();
  const auto sums = film->target().film.sum;
  for (const Canvas canvas : {Canvas{32, 24}, Canvas{64, 48}, Canvas{48, 64}}) {
    ASSERT_TRUE(film->holds(canvas));
    film->reshape(canvas);
    ASSERT_TRUE(film->keep_guides(true));
    ASSERT_TRUE(film->clear(stream_.get()));
    EXPECT_EQ(film->canvas(), canvas);
    EXPECT_EQ(film->samples(), 0u);
    EXPECT_EQ(film->target().film.sum, sums);
    ASSERT_TRUE(film->keep_guides(false));
    std::vector<std::uint8_t> picture(3 * film->pixels(), 7);
    ASSERT_TRUE(film->display(1, picture.data(), stream_.get()));
    EXPECT_EQ(film->device_bytes(), bytes);
    EXPECT_EQ(picture, std::vector<std::uint8_t>(picture.size(), 0));
  }
  EXPECT_FALSE(film->holds({65, 48}));
}

}  // namespace
}  // namespace diaphane::render::cuda
