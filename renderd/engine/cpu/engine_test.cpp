#include "renderd/engine/cpu/engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "renderd/engine/cpu/film.h"
#include "renderd/film/exposure.h"
#include "renderd/film/tone.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{61, 45};  // not a multiple of a tile

struct Session {
  std::unique_ptr<Engine> engine;
  std::unique_ptr<FrameRenderer> renderer;
};

Session session(const volume::Volume& volume, unsigned threads = 2, std::uint64_t seed = 1,
                std::uint64_t first_sample = 0) {
  Session s;
  s.engine = make_cpu_engine(threads);
  s.renderer = s.engine->renderer(s.engine->load(volume).value(), seed, first_sample).value();
  return s;
}

std::vector<float> radiance(FrameRenderer& renderer) {
  PictureRgbF picture;
  EXPECT_TRUE(renderer.radiance(picture));
  return picture.pixels;
}

std::vector<float> rendered(const volume::Volume& volume, const diaphane::v1::Scene& scene,
                            std::uint32_t samples, unsigned threads = 2, std::uint64_t seed = 1,
                            std::uint64_t first_sample = 0, Canvas canvas = kCanvas) {
  Session s = session(volume, threads, seed, first_sample);
  EXPECT_TRUE(s.renderer->set_scene(scene, canvas));
  EXPECT_EQ(s.renderer->render(samples, nullptr)->samples, samples);
  return radiance(*s.renderer);
}

TEST(CpuEngine, ImageDoesNotDependOnThreadsOrBatchSizes) {
  const volume::Volume volume = test::skull_volume();
  const std::vector<float> one = rendered(volume, test::skull_scene(), 7, 1);
  for (unsigned threads : {2u, 3u, 7u}) {
    EXPECT_EQ(rendered(volume, test::skull_scene(), 7, threads), one) << threads;
  }
  Session s = session(volume);
  ASSERT_TRUE(s.renderer->set_scene(test::skull_scene(), kCanvas));
  for (std::uint32_t samples : {1u, 4u, 2u}) ASSERT_TRUE(s.renderer->render(samples, nullptr));
  EXPECT_EQ(radiance(*s.renderer), one);
  EXPECT_NE(rendered(volume, test::skull_scene(), 7, 1, 2), one) << "another seed";
}

TEST(CpuEngine, DisjointSampleRangesHaveIndependentErrors) {
  // Two devices render one session, so their errors must be independent. The test is two-sided at
  // 1e-5 on the correlation of the errors over the pixels that vary (Fisher's z, normal).
  const volume::Volume volume = test::skull_volume();
  const auto truth = rendered(volume, test::skull_scene(), 256, 2, 99);
  const auto first = rendered(volume, test::skull_scene(), 4, 2, 1, 0);
  const auto second = rendered(volume, test::skull_scene(), 4, 2, 1, std::uint64_t{1} << 40);
  double ab = 0, aa = 0, bb = 0;
  std::size_t pixels = 0;
  // The colours of a pixel have correlated errors, so one of them is enough.
  for (std::size_t i = 1; i < truth.size(); i += 3) {
    const double a = first[i] - truth[i], b = second[i] - truth[i];
    if (a == 0 && b == 0) continue;
    ab += a * b;
    aa += a * a;
    bb += b * b;
    ++pixels;
  }
  ASSERT_GT(pixels, 300u);
  // The error of the truth is in both, which adds 4 / (4 + 256) to the correlation.
  const double r = ab / std::sqrt(aa * bb);
  EXPECT_LT(std::abs(std::atanh(r)), 4.42 / std::sqrt(pixels - 3.0) + 4.0 / 260);
}

TEST(CpuEngine, StopsBetweenTilesAndContinuesThere) {
  const volume::Volume volume = test::skull_volume();
  Session s = session(volume);
  ASSERT_TRUE(s.renderer->set_scene(test::skull_scene(), kCanvas));
  ASSERT_EQ(s.renderer->render(3, nullptr)->samples, 3u);
  const auto before = radiance(*s.renderer);
  int asked = 0;
  const auto stopped = s.renderer->render(100, [&] { return ++asked > 2; });
  ASSERT_TRUE(stopped);
  // If the machine is busy, the other thread may finish a sample before the caller checks again.
  const std::uint32_t ended = stopped->samples;
  ASSERT_LE(ended, 3u) << "polled at least once per sample";
  EXPECT_EQ(s.renderer->progress().samples, 3 + ended);
  if (ended == 0) {
    EXPECT_EQ(radiance(*s.renderer), before);
  }
  ASSERT_EQ(s.renderer->render(4 - ended, nullptr)->samples, 4 - ended);
  EXPECT_EQ(radiance(*s.renderer), rendered(volume, test::skull_scene(), 7))
      << "as if nothing had been stopped";
}

TEST(CpuEngine, SampleThatIsStoppedAtEachTileEnds) {
  const volume::Volume volume = test::skull_volume();
  Session s = session(volume);
  ASSERT_TRUE(s.renderer->set_scene(test::skull_scene(), kCanvas));
  std::uint32_t samples = 0;
  for (int call = 0; call < 10000 && samples == 0; ++call) {
    int asked = 0;
    samples = s.renderer->render(1, [&] { return ++asked > 1; })->samples;
  }
  ASSERT_EQ(samples, 1u);
  EXPECT_EQ(radiance(*s.renderer), rendered(volume, test::skull_scene(), 1));
}

TEST(CpuEngine, FilmCountsTheSamplesThatItDrops) {
  ThreadPool pool(2);
  RendererThreads threads(pool);
  CpuFilm film(threads, {5, 3});
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const std::uint64_t dropped : {1u, 4u, 0u, 2u}) {  // in even and odd samples
    std::fill_n(film.samples(), 15, Sample{.radiance = {1, 1, 1}, .hit_medium = true});
    for (std::uint64_t i = 0; i < dropped; ++i) film.samples()[4 * i].radiance.y = kNan;
    EXPECT_EQ(film.fold(), dropped);
  }
}

TEST(CpuEngine, RefusedSceneKeepsImageAndProgress) {
  Session s = session(test::skull_volume());
  ASSERT_TRUE(s.renderer->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(s.renderer->render(2, nullptr));
  const auto before = radiance(*s.renderer);
  diaphane::v1::Scene bad = test::skull_scene();
  bad.mutable_camera()->mutable_eye()->set_y(std::numeric_limits<double>::quiet_NaN());
  const auto refused = s.renderer->set_scene(bad, kCanvas);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera.eye.y");
  bad = test::skull_scene();
  bad.mutable_clip()->add_planes();
  bad.mutable_camera()->set_aperture_radius(2);
  EXPECT_EQ(s.renderer->set_scene(bad, kCanvas).error().field, "clip.planes[0].normal");
  bad = test::skull_scene();
  bad.mutable_slices()->mutable_axial()->set_shown(true);
  EXPECT_EQ(s.renderer->set_scene(bad, kCanvas).error().field, "slices.windowWidth");
  EXPECT_FALSE(s.renderer->set_scene(test::skull_scene(), Canvas{0, 4}));
  EXPECT_EQ(s.renderer->progress().samples, 2u);
  EXPECT_EQ(radiance(*s.renderer), before);
}

TEST(CpuEngine, RendersNothingBeforeASceneIsSet) {
  Session s = session(test::skull_volume());
  PictureRgb8 picture;
  EXPECT_FALSE(s.renderer->render(1, nullptr));
  EXPECT_FALSE(s.renderer->display(picture));
  EXPECT_TRUE(s.renderer->features().empty());
}

TEST(CpuEngine, SettingTheSceneAgainRestartsOnAnyCanvas) {
  const volume::Volume volume = test::skull_volume();
  Session s = session(volume);
  for (const Canvas canvas : {kCanvas, Canvas{20, 70}, kCanvas, Canvas{1, 1}, kCanvas}) {
    ASSERT_TRUE(s.renderer->set_scene(test::skull_scene(), canvas));
    EXPECT_EQ(s.renderer->progress().samples, 0u);
    EXPECT_TRUE(std::isinf(s.renderer->progress().error));
    ASSERT_TRUE(s.renderer->render(3, nullptr));
    EXPECT_EQ(radiance(*s.renderer), rendered(volume, test::skull_scene(), 3, 2, 1, 0, canvas));
  }
}

TEST(CpuEngine, SessionsOnOneEngineAreIndependent) {
  const volume::Volume volume = test::skull_volume();
  const std::shared_ptr<Engine> engine = make_cpu_engine(2);
  const auto shared = engine->load(volume).value();
  const auto alone = rendered(volume, test::skull_scene(), 5);
  std::atomic<int> wrong{0};
  std::vector<std::thread> users;
  for (int user = 0; user < 3; ++user) {
    users.emplace_back([&] {
      const auto renderer = engine->renderer(shared, 1, 0).value();
      for (int round = 0; round < 2; ++round) {
        if (!renderer->set_scene(test::skull_scene(), kCanvas)) ++wrong;
        if (!renderer->render(5, nullptr)) ++wrong;
        if (radiance(*renderer) != alone) ++wrong;
      }
    });
  }
  for (std::thread& user : users) user.join();
  EXPECT_EQ(wrong, 0);
}

TEST(CpuEngine, LimitsTheMemoryOfAllImagesTogether) {
  const std::uint64_t one = std::uint64_t{kCanvas.width} * kCanvas.height * 56;
  const std::shared_ptr<Engine> engine = make_cpu_engine(1, 5 * one / 2);
  const auto volume = engine->load(test::skull_volume()).value();
  const auto first = engine->renderer(volume, 1, 0).value();
  const auto second = engine->renderer(volume, 1, 0).value();
  ASSERT_TRUE(first->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(first->render(2, nullptr));
  const auto before = radiance(*first);
  ASSERT_TRUE(second->set_scene(test::skull_scene(), kCanvas));
  const auto refused = first->set_scene(test::skull_scene(), {2 * kCanvas.width, kCanvas.height});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(radiance(*first), before) << "the picture stays";
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(first->set_scene(test::skull_scene(), {kCanvas.width / 2, kCanvas.height / 2}))
        << "a smaller one is accepted, however often, since memory is given back";
  }
}

TEST(CpuEngine, ReplacesADraftByABetterPicture) {
  const volume::Volume volume = test::skull_volume();
  const auto engine = make_cpu_engine(2);
  const auto renderer = engine->renderer(engine->load(volume).value(), 1, 0, kLiveMethod).value();
  ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));

  const Batch draft = *renderer->render(8, nullptr);
  EXPECT_EQ(draft.samples, 2u) << "a batch ends with the draft";
  EXPECT_FALSE(draft.refined);
  const double draft_error = renderer->progress().error;
  EXPECT_TRUE(std::isfinite(draft_error));
  const std::vector<float> draft_picture = radiance(*renderer);

  const Batch first = *renderer->render(1, nullptr);
  EXPECT_TRUE(first.refined);
  EXPECT_EQ(renderer->progress().samples, 3u);
  EXPECT_EQ(renderer->progress().error, draft_error) << "a bound until its own error is known";
  EXPECT_NE(radiance(*renderer), draft_picture);

  ASSERT_TRUE(renderer->render(1, nullptr));
  EXPECT_EQ(renderer->progress().samples, 4u);
  // Two samples of either kind. The exact walk's variance is less than a quarter of tracking's.
  EXPECT_LT(renderer->progress().error, draft_error / 2);

  ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
  EXPECT_FALSE(renderer->render(1, nullptr)->refined) << "each picture begins with a draft";
}

TEST(CpuEngine, KeepsADraftIfThereIsNoMemoryForAnotherFilm) {
  const volume::Volume volume = test::skull_volume();
  const std::uint64_t one = std::uint64_t{kCanvas.width} * kCanvas.height * 56;
  const auto engine = make_cpu_engine(2, 3 * one / 2);
  const auto renderer = engine->renderer(engine->load(volume).value(), 1, 0, kLiveMethod).value();
  ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(renderer->render(2, nullptr));
  const double error = renderer->progress().error;
  EXPECT_FALSE(renderer->render(30, nullptr)->refined);
  EXPECT_EQ(renderer->progress().samples, 32u);
  EXPECT_LT(renderer->progress().error, error);
}

TEST(CpuEngine, DisplayEqualsTheToneMappedRadiance) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_display()->set_exposure(-1);
  Session s = session(test::skull_volume());
  ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
  ASSERT_TRUE(s.renderer->render(2, nullptr));
  PictureRgb8 shown;
  ASSERT_TRUE(s.renderer->display(shown));
  const auto linear = radiance(*s.renderer);
  ASSERT_EQ(shown.pixels.size(), linear.size());
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double exact = 255 * std::pow(std::clamp(0.5 * linear[i], 0.0, 1.0), 1 / 2.2);
    ASSERT_NEAR(shown.pixels[i], exact, 0.502);
  }
}

/// Black matter before a background of radiance 1, so that a pixel shows the transmittance.
diaphane::v1::Scene shadow_scene(double extinction, double eye_distance = 5000,
                                 double fov_degrees = 0.002) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{-32768, 1}, {32767, 1}}, 0, 0, 0);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  test::set_camera(scene, 0, -eye_distance, 0, fov_degrees);
  test::set(scene.mutable_display()->mutable_background(), 1, 1, 1);
  return scene;
}

/// Compares the mean over 4 x 4 pixels and `samples` samples with exp(-depth). A sample is 0 or 1,
/// so the error is binomial.
void expect_transmittance(const volume::Volume& volume, const diaphane::v1::Scene& scene,
                          double depth, std::size_t tests, const char* what) {
  constexpr std::uint32_t kSamples = 2000;
  const auto pixels = rendered(volume, scene, kSamples, 2, 1, 0, {4, 4});
  const double mean =
      std::accumulate(pixels.begin(), pixels.end(), 0.0) / static_cast<double>(pixels.size());
  const double p = std::exp(-depth);
  const double error = std::sqrt(p * (1 - p) / (16 * kSamples));
  EXPECT_NEAR(mean, p, test::critical_z(test::sidak(1e-3, tests)) * error + 1e-5) << what;
}

TEST(Degenerate, VolumesHaveTheirDefinedTransmittance) {
  const auto one = [](double, double, double) { return 5.0; };
  constexpr std::size_t kTests = 9;
  expect_transmittance(test::make_volume({1, 1, 1}, {2, 3, 4}, one), shadow_scene(0.2), 0.6, kTests,
                       "1x1x1");
  expect_transmittance(test::make_volume({1, 30, 40}, {2, 1, 1}, one), shadow_scene(0.02), 0.6,
                       kTests, "thin x");
  expect_transmittance(test::make_volume({30, 1, 40}, {1, 2, 1}, one), shadow_scene(0.3), 0.6,
                       kTests, "thin y");
  expect_transmittance(test::make_volume({30, 40, 1}, {1, 1, 2}, one), shadow_scene(0.02), 0.8,
                       kTests, "thin z");
  expect_transmittance(test::constant_volume(10, -32768), shadow_scene(0.1), 1, kTests,
                       "all INT16_MIN");
  expect_transmittance(test::constant_volume(10, 32767), shadow_scene(0.1), 1, kTests,
                       "all INT16_MAX");
  expect_transmittance(test::constant_volume(10, 0), shadow_scene(0), 0, kTests, "nothing there");
  expect_transmittance(test::constant_volume(10, 0), shadow_scene(1e6), 1e7, kTests, "all opaque");
  expect_transmittance(test::make_volume({40, 40, 2}, {0.4, 0.4, 12}, one), shadow_scene(0.05), 0.8,
                       kTests, "1:30");
}

TEST(Degenerate, CameraMayBeFarAwayOrInside) {
  const auto five = [](double, double, double) { return 5.0; };
  const volume::Volume volume = test::make_volume({20, 20, 20}, {1, 1, 1}, five);
  expect_transmittance(volume, shadow_scene(0.05, 9e5, 0.001), 1, 3, "900 m");
  expect_transmittance(volume, shadow_scene(0.1, 5), 1.5, 3, "inside");
  expect_transmittance(volume, shadow_scene(0.1, 10), 2, 3, "on the face");
}

TEST(Degenerate, ImagesStayFinite) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(1e6);
  for (const double g : {0.0, 0.999999999, -0.999999999}) {
    scene.mutable_phase()->set_g(g);
    // The added lamp is inside the volume and has enormous power.
    test::add_lamp(scene, 0, 0, 1, 2, 1e12);
    Session s = session(test::skull_volume());
    ASSERT_TRUE(s.renderer->set_scene(scene, {32, 32}));
    const auto batch = s.renderer->render(4, nullptr);
    ASSERT_TRUE(batch);
    EXPECT_EQ(batch->dropped_samples, 0u) << g;
    for (float x : radiance(*s.renderer)) {
      ASSERT_TRUE(std::isfinite(x));
      ASSERT_GE(x, 0);
    }
  }
}

/// The skull with its lights multiplied by `factor`, and automatic exposure.
diaphane::v1::Scene lit_skull(double factor) {
  diaphane::v1::Scene scene = test::skull_scene();
  for (diaphane::v1::Light& light : *scene.mutable_lights()) light.set_intensity(factor);
  scene.mutable_display()->set_automatic_exposure(true);
  return scene;
}

/// Returns the mean over the pixels and colours that hit contents.
double mean_of_subject(FrameRenderer& renderer) {
  const std::vector<float> pixels = radiance(renderer);
  std::vector<std::uint8_t> met;
  EXPECT_TRUE(renderer.contents(met));
  double sum = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (met[i / 3] != 0) sum += static_cast<double>(pixels[i]);
  }
  return sum / (3.0 * std::accumulate(met.begin(), met.end(), 0.0));
}

TEST(AutomaticExposure, BringsTheSubjectToTheNearerEndOfTheRange) {
  const volume::Volume volume = test::skull_volume();
  for (const auto& [factor, wanted] : {std::pair{1.0 / 32, kDarkestMean}, {8.0, kBrightestMean}}) {
    for (const std::uint32_t samples : {1u, 8u}) {
      Session s = session(volume);
      diaphane::v1::Scene scene = lit_skull(factor);
      scene.mutable_display()->set_exposure(0.5);
      ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
      ASSERT_TRUE(s.renderer->render(samples, nullptr));
      const double stops = s.renderer->progress().stops;
      EXPECT_NEAR(mean_of_subject(*s.renderer) * std::exp2(stops), wanted, wanted / 32);
      PictureRgb8 shown;
      ASSERT_TRUE(s.renderer->display(shown));
      const std::vector<float> pixels = radiance(*s.renderer);
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        ASSERT_EQ(shown.pixels[i], to_display(pixels[i], display_scale(0.5 + stops)));
      }
    }
  }
}

TEST(AutomaticExposure, IsLeftOutWithoutTheSettingAndWithSlices) {
  const volume::Volume volume = test::skull_volume();
  diaphane::v1::Scene manual = lit_skull(64), slices = lit_skull(64);
  manual.mutable_display()->set_automatic_exposure(false);
  slices.mutable_slices()->mutable_axial()->set_shown(true);
  slices.mutable_slices()->set_window_width(1000);
  for (const auto& scene : {manual, slices}) {
    Session s = session(volume);
    ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
    ASSERT_TRUE(s.renderer->render(2, nullptr));
    EXPECT_EQ(s.renderer->progress().stops, 0);
  }
}

TEST(CpuEngine, RefusesVolumeWithMissingVoxels) {
  volume::Volume volume = test::skull_volume();
  volume.voxels.pop_back();
  const auto loaded = make_cpu_engine(1)->load(volume);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInvalid);
}

/// From 64 samples on, the estimated error is within 10% of the true one for a scene like the
/// cranium. The true error is the root mean square over independent pictures, compared with a
/// converged picture whose own noise is subtracted. In the smaller picture of the gate, about 400
/// pixels have contents. Over eight pictures, the spread of the ratio is below 2% (see
/// Estimate.IsWithinTenPercentFrom64SamplesForBothPointSets).
TEST(ErrorEstimate, IsWithinTenPercentOfTheTrueError) {
  const std::uint32_t side = test::gate_or_nightly(32u, 64u);
  const Canvas kSmall{side, side};
  const std::uint32_t kReference = test::gate_or_nightly(512u, 2048u);
  const volume::Volume volume = test::skull_volume();
  Session reference = session(volume, 2, 99);
  ASSERT_TRUE(reference.renderer->set_scene(test::skull_scene(), kSmall));
  ASSERT_TRUE(reference.renderer->render(kReference, nullptr));
  const auto truth = radiance(*reference.renderer);
  // This repeats the definition in film/error.h independently. A pixel has contents if it shows
  // anything other than the background alone.
  std::vector<float> values;
  std::vector<bool> content(truth.size());
  for (std::size_t p = 0; p < truth.size(); p += 3) {
    const bool met = truth[p] != 0.5f || truth[p + 1] != 0.5f || truth[p + 2] != 0.5f;
    for (std::size_t c = p; c < p + 3; ++c) {
      content[c] = met;
      if (met) values.push_back(truth[c]);
    }
  }
  std::sort(values.begin(), values.end());
  const double white = values.at(values.size() * 99 / 100);
  const std::uint32_t most = test::gate_or_nightly(128u, 256u);
  for (const auto& [samples, filmic] : {std::pair{64u, false}, {most, false}, {64u, true}}) {
    const auto tone = [&, filmic = filmic](double x) {
      x /= white;
      if (filmic) x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
      return std::pow(std::clamp(x, 0.0, 1.0), 1 / 2.2);
    };
    diaphane::v1::Scene scene = test::skull_scene();
    if (filmic) scene.mutable_display()->set_curve(diaphane::v1::Display::FILMIC);
    double estimated = 0, measured = 0;
    constexpr int kPictures = 8;
    for (int i = 0; i < kPictures; ++i) {
      Session s = session(volume, 2, static_cast<std::uint64_t>(i) + 1);
      ASSERT_TRUE(s.renderer->set_scene(scene, kSmall));
      ASSERT_TRUE(s.renderer->render(samples, nullptr));
      const double e = s.renderer->progress().error;
      estimated += e * e / kPictures;
      const auto picture = radiance(*s.renderer);
      double squared = 0;
      for (std::size_t c = 0; c < picture.size(); ++c) {
        if (!content[c]) continue;
        const double off = tone(picture[c]) - tone(truth[c]);
        squared += off * off;
      }
      measured += squared / static_cast<double>(values.size()) / kPictures;
    }
    measured /= 1 + static_cast<double>(samples) / kReference;
    const double ratio = std::sqrt(estimated / measured);
    EXPECT_GT(ratio, 0.9) << samples << filmic;
    EXPECT_LT(ratio, 1.1) << samples << filmic;
  }
}

/// Returns a volume with one of two phases: the skull, or the skull with denser bone.
volume::Volume phase_of_skull(std::uint32_t phase) {
  volume::Volume volume = test::skull_volume();
  volume.header.phases = {{volume::PhaseKind::kCycle, 0}, {volume::PhaseKind::kCycle, 50}};
  volume.phase = phase;
  for (std::int16_t& value : volume.voxels) {
    if (phase == 1 && value > 300) value = static_cast<std::int16_t>(value + 150);
  }
  return volume;
}

TEST(CpuEngine, PictureOfAPhaseEqualsThatOfThePhaseAlone) {
  const auto scene = test::skull_scene();
  Session s = session(phase_of_skull(0));
  const auto other = s.engine->load(phase_of_skull(1)).value();
  const auto first = s.engine->load(phase_of_skull(0)).value();
  ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
  // Each phase twice, because the second time its tables exist already.
  for (int turn = 0; turn < 2; ++turn) {
    for (const std::uint32_t phase : {1u, 0u}) {
      ASSERT_TRUE(s.renderer->set_volume(phase == 1 ? other : first));
      ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
      ASSERT_EQ(s.renderer->render(3, nullptr)->samples, 3u);
      EXPECT_EQ(radiance(*s.renderer), rendered(phase_of_skull(phase), scene, 3)) << phase;
      EXPECT_EQ(s.renderer->progress().samples, 3u);
    }
  }
  EXPECT_NE(rendered(phase_of_skull(0), scene, 3), rendered(phase_of_skull(1), scene, 3));
}

TEST(CpuEngine, KeepsPictureUntilTheSceneOfAnotherVolumeIsSet) {
  const auto scene = test::skull_scene();
  Session s = session(phase_of_skull(0));
  const auto other = s.engine->load(phase_of_skull(1)).value();
  ASSERT_TRUE(s.renderer->set_scene(scene, kCanvas));
  ASSERT_TRUE(s.renderer->render(1, nullptr));
  ASSERT_TRUE(s.renderer->set_volume(other));
  diaphane::v1::Scene wrong = scene;
  wrong.mutable_camera()->set_vertical_fov_degrees(-1);
  EXPECT_FALSE(s.renderer->set_scene(wrong, kCanvas));
  ASSERT_TRUE(s.renderer->render(1, nullptr));
  EXPECT_EQ(radiance(*s.renderer), rendered(phase_of_skull(0), scene, 2));
  const auto foreign = make_cpu_engine(1)->load(phase_of_skull(1)).value();
  EXPECT_TRUE(s.renderer->set_volume(foreign)) << "CPU engines share the machine's memory";
}

}  // namespace
}  // namespace diaphane::render
