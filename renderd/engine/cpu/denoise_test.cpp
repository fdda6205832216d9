// Tests the denoiser alone, on synthetic films, and in the engine, on scenes.
#include "renderd/engine/cpu/denoise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/film/denoise.h"
#include "renderd/film/tone.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{61, 45};  // not a multiple of a tile
constexpr std::size_t kPixels = 61 * 45;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A film of synthetic samples, with guides.
struct Made {
  std::vector<double> sum = std::vector<double>(3 * kPixels);
  std::vector<float> difference = std::vector<float>(3 * kPixels);
  std::vector<std::uint32_t> state = std::vector<std::uint32_t>(kPixels);
  std::vector<PackedGuides> guides =
      std::vector<PackedGuides>(kPixels, pack({1.0f, 100.0f, {0.5f, 0.5f, 0.5f}, {0, 0, 1}}));
  std::uint64_t samples = 0;

  /// `sample(pixel, n)` returns a grey radiance.
  template <typename Sample>
  void fill(std::uint64_t count, const Sample& sample) {
    samples = count;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      PixelBatch batch;
      for (std::uint64_t n = 0; n < count; ++n) {
        const float x = sample(pixel, n);
        batch.add({x, x, x}, true, n);
      }
      fold({sum.data(), difference.data(), state.data()}, pixel, batch);
    }
  }
  std::vector<float> raw() const {
    std::vector<float> out;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      const Float3 mean = estimate_of(view(), pixel, samples).mean;
      out.insert(out.end(), {mean.x, mean.y, mean.z});
    }
    return out;
  }
  ConstFilmView view() const { return {sum.data(), difference.data(), state.data()}; }
  std::vector<float> denoised(unsigned threads = 2) const {
    ThreadPool pool(threads);
    RendererThreads used(pool);
    return denoise(used, {view(), guides.data(), kCanvas, samples, 1.0f, 1.0f});
  }
};

std::uint32_t column(std::size_t pixel) {
  return static_cast<std::uint32_t>(pixel % kCanvas.width);
}

/// An exponential variable, whose mean and standard deviation are both `mean`.
float noise(float mean, std::size_t pixel, std::uint64_t n) {
  return mean * Random(3, static_cast<std::uint32_t>(pixel), n).exponential();
}

double rmse(const std::vector<float>& a, const std::function<double(std::size_t)>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(a[i] - truth(i / 3), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// The halves differ while their mean is the same everywhere, so the whole filtered picture is
/// used.
TEST(Denoiser, ConstantImageStaysConstantWithAnyGuides) {
  for (const std::uint64_t samples : {1ull, 2ull, 6ull}) {
    Made film;
    film.fill(samples, [&](std::size_t p, std::uint64_t n) {
      const float apart = samples == 1 ? 0.0f : (p * 7919 % 5 < 2 ? 0.125f : -0.125f);
      return 0.25f + (n % 2 == 0 ? apart : -apart);
    });
    for (std::size_t i = 0; i < kPixels; ++i) {
      // The guides are constant in blocks, so that pixels have both similar and different
      // neighbours.
      Random r(9, column(i) / 7, i / kCanvas.width / 7);
      film.guides[i] = pack({r.one(), 200 * r.one(), {r.one(), r.one(), r.one()}, {0, r.one(), 0}});
    }
    for (const float x : film.denoised()) ASSERT_NEAR(x, 0.25f, 1e-6f);
  }
}

/// With noise of 1, 2 and 16 samples on an even surface, the noise falls. The energy is that of the
/// truth within 5 standard errors of the picture's mean.
TEST(Denoiser, ReducesNoiseAndKeepsTheEnergy) {
  for (const std::uint64_t samples : {1ull, 2ull, 16ull}) {
    Made film;
    film.fill(samples, [](std::size_t p, std::uint64_t n) { return noise(0.2f, p, n); });
    const auto picture = film.denoised();
    const auto truth = [](std::size_t) { return 0.2; };
    EXPECT_LT(rmse(picture, truth), 0.3 * rmse(film.raw(), truth)) << samples;
    double mean = 0;
    for (const float x : picture) mean += x / static_cast<double>(picture.size());
    const double deviation = 0.2 / std::sqrt(static_cast<double>(samples * kPixels));
    EXPECT_NEAR(mean, 0.2, 5 * deviation) << samples;
  }
}

/// The picture has a step where one of the guides has one. Each side must keep its brightness.
TEST(Denoiser, KeepsEdgesOfEachGuide) {
  const Guides plain{1, 100, {0.5f, 0.5f, 0.5f}, {0, 0, 1}};
  std::vector<Guides> others(5, plain);
  others[0].opacity = 0.4f;
  others[1].depth = 160;
  others[2].albedo = {0.5f, 0.1f, 0.1f};
  others[3].normal = {0, 0, -1};
  others[4] = {0.5f, 80, {0.05f, 0.2f, 0.1f}, {0.5f, 0, 0}};
  for (std::size_t which = 0; which < others.size(); ++which) {
    Made film;
    const auto level = [](std::size_t p) { return column(p) < 30 ? 0.1f : 0.6f; };
    film.fill(8, [&](std::size_t p, std::uint64_t n) { return noise(level(p), p, n); });
    for (std::size_t i = 0; i < kPixels; ++i) {
      film.guides[i] = pack(column(i) < 30 ? plain : others[which]);
    }
    const auto picture = film.denoised();
    double before = 0, after = 0;  // sums over the two columns at the edge
    for (std::size_t i = 0; i < kPixels; ++i) {
      if (column(i) == 29) before += picture[3 * i] / kCanvas.height;
      if (column(i) == 30) after += picture[3 * i] / kCanvas.height;
    }
    // With 8 samples of 45 pixels, the standard error is 5% of the level.
    EXPECT_NEAR(before, 0.1, 4 * 0.05 * 0.1) << which;
    EXPECT_NEAR(after, 0.6, 4 * 0.05 * 0.6) << which;
    EXPECT_LT(rmse(picture, level), 0.5 * rmse(film.raw(), level)) << which;
  }
}

TEST(Denoiser, SlicePixelsNeitherChangeNorBleed) {
  Made film;
  const auto slice = [](std::size_t p) { return column(p) >= 20 && column(p) < 40; };
  film.fill(4, [&](std::size_t p, std::uint64_t n) {
    return slice(p) ? (p % 2 == 0 ? 9.0f : 0.0f) : noise(0.2f, p, n);
  });
  for (std::size_t p = 0; p < kPixels; ++p) {
    if (slice(p)) film.state[p] |= kShowsSlice;
  }
  const auto picture = film.denoised(), raw = film.raw();
  double beside = 0;
  for (std::size_t p = 0; p < kPixels; ++p) {
    if (slice(p)) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(picture[3 * p + c], raw[3 * p + c]);
    } else {
      beside = std::max(beside, double{picture[3 * p]});
    }
  }
  EXPECT_LT(beside, 0.8) << "a bright pixel of the slice lit its neighbours";
}

TEST(Denoiser, ResultDoesNotDependOnTheNumberOfThreads) {
  Made film;
  film.fill(3, [](std::size_t p, std::uint64_t n) { return noise(0.2f, p, n); });
  const auto one = film.denoised(1);
  EXPECT_EQ(film.denoised(2), one);
  EXPECT_EQ(film.denoised(5), one);
}

/// The film has pixels whose samples were all dropped, sums that overflowed, and invalid guides.
TEST(Denoiser, DoesNotSpreadNonFiniteValues) {
  for (const std::uint64_t samples : {1ull, 4ull}) {
    Made film;
    film.fill(samples, [](std::size_t p, std::uint64_t n) {
      return p % 97 == 5 ? kNan : noise(0.2f, p, n);
    });
    for (std::size_t p = 11; p < kPixels; p += 101) {
      film.sum[3 * p] = std::numeric_limits<double>::infinity();
      film.difference[3 * p + 1] = kNan;
    }
    for (std::size_t p = 17; p < kPixels; p += 89) {
      film.guides[p] = with_samples(film.guides[p], 1, Guides{kNan, kNan, {}, {}}, 1);
    }
    const auto picture = film.denoised();
    for (std::size_t p = 0; p < kPixels; ++p) {
      if (p % 101 == 11) continue;  // its own sum is infinite, so it is raw
      for (int c = 0; c < 3; ++c) {
        ASSERT_TRUE(std::isfinite(picture[3 * p + c])) << p;
        ASSERT_LT(picture[3 * p + c], 3.0f) << p;
      }
    }
    // The pixels beside them are still denoised.
    double left = 0, before = 0;
    const auto raw = film.raw();
    for (std::size_t p = 0; p < kPixels; ++p) {
      if (p % 97 == 5 || p % 101 == 11) continue;
      left += squared(picture[3 * p] - 0.2f);
      before += squared(raw[3 * p] - 0.2f);
    }
    EXPECT_LT(left, 0.3 * before) << samples;
  }
}

/// The guides do not show this texture, so the filter blurs it however many samples there are. Of
/// the remaining noise with variance V, the denoiser should remove the share V / (V + B), where B
/// is the variance of the texture. No filter can know more. The test allows a factor of 2. The
/// picture is therefore smooth with few samples, and finally becomes the raw one.
TEST(Denoiser, EffectFadesAsTheErrorFalls) {
  const auto level = [](std::size_t p) {
    return 0.3f + 0.05f * static_cast<float>((p * 7919) % 13) / 13;
  };
  const double texture = 0.05 * 0.05 / 12;
  for (const std::uint64_t samples : {1ull, 4ull, 64ull, 4096ull, 65536ull, 1048576ull}) {
    Made film;
    // Two halves with the noise of `samples` samples.
    const double deviation = 1 / std::sqrt(static_cast<double>(samples));
    film.fill(samples == 1 ? 1 : 2, [&](std::size_t p, std::uint64_t n) {
      const double x = noise(1.0f, p, n) - 1;
      return static_cast<float>(level(p) * (1 + deviation * x * (samples == 1 ? 1 : std::sqrt(2))));
    });
    const auto raw = film.raw(), picture = film.denoised();
    EXPECT_LE(rmse(picture, level), 1.01 * rmse(raw, level)) << samples;
    double moved = 0, noisy = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      moved += std::pow(picture[i] - raw[i], 2);
      noisy += std::pow(raw[i] - level(i / 3), 2);
    }
    const double variance = noisy / static_cast<double>(raw.size());
    EXPECT_LT(moved / noisy, 2 * variance / (variance + texture)) << samples;
    if (samples <= 64) EXPECT_GT(moved / noisy, 0.5) << samples;
  }
}

// Tests in the engine.

/// Returns the sum of squared differences to `truth` on the screen.
double squared_error_of(const std::vector<float>& picture, const std::vector<float>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    sum += std::pow(static_cast<double>(tone(picture[i]) - tone(truth[i])), 2);
  }
  return sum;
}

/// Compares the squared error with and without denoising for each of 8 seeds. The mean of the
/// differences must be negative, or positive by less than its standard error explains (one-sided,
/// 1e-4 over all cases, Sidak). The reference is the same for both, and its own error does not
/// correlate with either.
void expect_never_worse(const diaphane::v1::Scene& scene, Walk walk,
                        std::initializer_list<std::uint32_t> counts, const char* name) {
  constexpr std::uint64_t kSeeds = 8;
  constexpr std::size_t kCases = 4 * 5 + 3;
  static const auto engine = make_cpu_engine(0);
  static const auto loaded = engine->load(test::skull_volume()).value();
  const Method method{.walk = walk};
  auto reference = engine->renderer(loaded, 1000, 0, method).value();
  ASSERT_TRUE(reference->set_scene(scene, kCanvas));
  ASSERT_TRUE(reference->render(8 * std::max(counts), nullptr));
  PictureRgbF truth;
  ASSERT_TRUE(reference->radiance(truth));
  std::vector<test::Moments> worse(counts.size()), left(counts.size());
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    auto renderer = engine->renderer(loaded, seed, 0, method).value();
    renderer->prepare_denoising(true);
    ASSERT_TRUE(renderer->set_scene(scene, kCanvas));
    std::uint32_t done = 0;
    std::size_t i = 0;
    for (const std::uint32_t count : counts) {
      ASSERT_TRUE(renderer->render(count - done, nullptr));
      done = count;
      PictureRgbF raw, smooth;
      ASSERT_TRUE(renderer->radiance(raw));
      ASSERT_TRUE(renderer->radiance_denoised(smooth));
      const double of_raw = squared_error_of(raw.pixels, truth.pixels);
      const double of_smooth = squared_error_of(smooth.pixels, truth.pixels);
      worse[i].add(of_smooth - of_raw);
      left[i++].add(of_smooth / of_raw);
    }
  }
  std::size_t i = 0;
  for (const std::uint32_t count : counts) {
    const double limit = test::critical_t(2 * test::sidak(1e-4, kCases), kSeeds - 1);
    EXPECT_LE(worse[i].mean, limit * worse[i].error_of_mean())
        << name << ", " << count << " samples: squared error times " << left[i].mean;
    if (count <= 4) {
      // The first pictures of tracking are mostly noise, while those of the exact walk are already
      // good.
      EXPECT_LT(left[i].mean, walk == Walk::kTracking ? 0.5 : 1.0) << name << ", " << count;
    }
    ++i;
  }
}

TEST(DenoisedPicture, IsNeverWorseThanTheRawImage) {
  const std::initializer_list<std::uint32_t> counts{1, 2, 4, 16, 64};
  auto thin = test::skull_scene(), dense = test::skull_scene(), dark = test::skull_scene();
  const double extinction = thin.transfer_function().extinction_per_mm();
  thin.mutable_transfer_function()->set_extinction_per_mm(0.05 * extinction);
  dense.mutable_transfer_function()->set_extinction_per_mm(30 * extinction);
  for (auto& light : *dark.mutable_lights()) light.set_intensity(0.01);
  expect_never_worse(test::skull_scene(), Walk::kTracking, counts, "skull");
  expect_never_worse(thin, Walk::kTracking, counts, "thin");
  expect_never_worse(dense, Walk::kTracking, counts, "dense");
  expect_never_worse(dark, Walk::kTracking, counts, "dark");
  expect_never_worse(test::skull_scene(), Walk::kAuto, {1, 2, 4}, "skull by the exact walk");
}

TEST(DenoisedPicture, EqualsTheRawImageWithoutGuidesAndAfterConvergence) {
  const volume::Volume volume = test::skull_volume();
  const auto engine = make_cpu_engine(2);
  auto renderer = engine->renderer(engine->load(volume).value(), 1, 0).value();
  ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(renderer->render(4, nullptr));
  PictureRgb8 raw, smooth;
  ASSERT_TRUE(renderer->display(raw));
  EXPECT_EQ(renderer->display_denoised(smooth), false);
  EXPECT_EQ(smooth.pixels, raw.pixels);

  renderer->prepare_denoising(true);
  auto still = test::skull_scene();
  // Without light there is no noise.
  still.mutable_lights()->Clear();
  ASSERT_TRUE(renderer->set_scene(still, kCanvas));
  ASSERT_TRUE(renderer->render(2, nullptr));
  ASSERT_TRUE(renderer->display(raw));
  ASSERT_TRUE(renderer->display_denoised(smooth));
  EXPECT_EQ(smooth.pixels, raw.pixels);
}

TEST(DenoisedPicture, RecordingGuidesDoesNotChangeSamples) {
  const volume::Volume volume = test::skull_volume();
  const auto engine = make_cpu_engine(2);
  const auto loaded = engine->load(volume).value();
  PictureRgbF pictures[2];
  for (const bool guided : {false, true}) {
    auto renderer = engine->renderer(loaded, 1, 0).value();
    renderer->prepare_denoising(guided);
    ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
    ASSERT_TRUE(renderer->render(6, nullptr));
    ASSERT_TRUE(renderer->radiance(pictures[guided]));
  }
  // Another variant of the kernel computes the same numbers except for rounding, which may move a
  // collision in a few pixels.
  std::size_t other = 0;
  for (std::size_t i = 0; i < pictures[0].pixels.size(); ++i) {
    other += std::abs(pictures[0].pixels[i] - pictures[1].pixels[i]) > 1e-3f;
  }
  EXPECT_LT(other, pictures[0].pixels.size() / 50);
}

}  // namespace
}  // namespace diaphane::render
