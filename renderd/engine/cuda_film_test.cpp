// The film's kernels against the host's functions on the same numbers.
#include "renderd/engine/cuda_film.h"

#include <cstring>
#include <random>

#include "renderd/engine/cuda_test_support.h"

namespace diaphane::render::cuda {
namespace {

constexpr Canvas kCanvas{75, 41};
constexpr std::size_t kPixels = 75 * 41;

/// Batches of some samples, a few of them dropped, some pixels without matter.
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
      ASSERT_EQ(cudaMemcpyAsync(film_.batch(), batch.data(), kPixels * sizeof(PixelBatch),
                                cudaMemcpyHostToDevice, stream_.get()),
                cudaSuccess);
      ASSERT_TRUE(film_.fold(samples, stream_.get()));
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

TEST_F(CudaFilmTest, SamplesThatAreNotFiniteAreDroppedAndCounted) {
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

TEST_F(CudaFilmTest, TheErrorIsTheHosts) {
  WhiteHistogram histogram;
  count_white(host(), 0, kPixels, film_.samples(), histogram);
  const float white = white_from_histogram(histogram);
  std::vector<TileError> tiles;
  for (std::uint32_t y = 0; y < (kCanvas.height + kTileSize - 1) / kTileSize; ++y) {
    for (std::uint32_t x = 0; x < (kCanvas.width + kTileSize - 1) / kTileSize; ++x) {
      tiles.push_back(tile_error(host(), kCanvas, x, y, film_.samples(), white));
    }
  }
  const double expected = total_error(tiles, film_.samples());
  const auto error = film_.error(stream_.get());
  ASSERT_TRUE(error);
  EXPECT_NEAR(*error, expected, 1e-5 * expected);
}

TEST_F(CudaFilmTest, ThePictureIsTheHostsWithinOneLevel) {
  std::vector<std::uint8_t> picture(3 * kPixels);
  ASSERT_TRUE(film_.display(0.25f, picture.data(), stream_.get()));
  std::size_t other = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const Float3 mean = estimate_of(host(), i, film_.samples()).mean;
    for (int c = 0; c < 3; ++c) {
      const int expected = to_display(mean[c], 0.25f);
      ASSERT_NEAR(picture[3 * i + c], expected, 1);
      other += picture[3 * i + c] != expected;
    }
  }
  // Rounding differs only where a value lies within 1e-4 of a level's border.
  EXPECT_LT(other, 3 * kPixels / 500);
}

}  // namespace
}  // namespace diaphane::render::cuda
