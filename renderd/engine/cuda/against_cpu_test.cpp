// The CPU engine and the CUDA engine execute the same kernel, so their pictures have the same mean.
//
// Welch's t-test compares each tile of 16 x 16 pixels and each colour. One observation is the mean
// over a tile of one run, and each engine makes 48 runs with separate seeds. The significance is
// 1e-4 over all tests of a pair of pictures (Sidak). The last test shows that a bias of 2% is
// detected.
#include <cmath>
#include <numeric>
#include <string>

#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_device.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_textures.h"

namespace diaphane::render::cuda {
namespace {

constexpr Canvas kCanvas{64, 48};
constexpr std::uint32_t kTile = 16;
constexpr std::uint32_t kRuns = 48;
constexpr std::uint32_t kFew = 64, kMany = 512;  ///< samples per pixel in a run
constexpr double kAlpha = 1e-4;

struct Moments {
  double sum = 0, squares = 0;

  void add(double x) {
    sum += x;
    squares += x * x;
  }
  double mean() const { return sum / kRuns; }
  /// Returns the variance of the mean.
  double variance() const { return (squares - sum * sum / kRuns) / (kRuns - 1) / kRuns; }
};

/// A turn by 0.44 about z and a shift.
volume::Matrix turned() {
  const double c = std::cos(0.44), s = std::sin(0.44);
  return {c, -s, 0, 3, s, c, 0, -2, 0, 0, 1, 1.5, 0, 0, 0, 1};
}

/// Returns three moments per tile, one for each colour. `second` is a second scan, or null.
std::vector<Moments> tile_moments(Engine& engine, const volume::Volume& volume,
                                  const diaphane::v1::Scene& scene, std::uint32_t samples,
                                  std::uint64_t first_seed,
                                  Method method = {.walk = Walk::kTracking},
                                  const volume::Volume* second = nullptr) {
  const std::uint32_t across = kCanvas.width / kTile, down = kCanvas.height / kTile;
  std::vector<Moments> moments(3 * across * down);
  const auto loaded = engine.load(volume);
  EXPECT_TRUE(loaded);
  const auto loaded_second = second != nullptr ? engine.load(*second).value() : nullptr;
  for (std::uint32_t run = 0; run < kRuns && loaded; ++run) {
    auto one = engine.renderer(*loaded, first_seed + run, 0, method);
    EXPECT_TRUE(one);
    if (loaded_second != nullptr) EXPECT_TRUE((*one)->set_second(loaded_second, turned()));
    EXPECT_TRUE(render_all(**one, scene, kCanvas, samples));
    const auto pixels = radiance_of(**one);
    std::vector<double> sums(moments.size());
    for (std::uint32_t y = 0; y < kCanvas.height; ++y) {
      for (std::uint32_t x = 0; x < kCanvas.width; ++x) {
        for (std::uint32_t c = 0; c < 3; ++c) {
          sums[3 * (x / kTile + across * (y / kTile)) + c] +=
              static_cast<double>(pixels[3 * (x + kCanvas.width * y) + c]);
        }
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) moments[i].add(sums[i] / (kTile * kTile));
  }
  return moments;
}

/// Returns how many tests of `a` against `b` reject the hypothesis of equal means.
int rejections(const std::vector<Moments>& a, const std::vector<Moments>& b) {
  const double p = sidak(kAlpha, a.size());
  int rejected = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double va = a[i].variance(), vb = b[i].variance();
    if (!(va + vb > 1e-20)) {
      // No ray makes this tile noisy, so it shows the background in both pictures.
      rejected += std::abs(a[i].mean() - b[i].mean()) > 1e-6;
      continue;
    }
    const double dof = (va + vb) * (va + vb) / ((va * va + vb * vb) / (kRuns - 1));
    const double t = (a[i].mean() - b[i].mean()) / std::sqrt(va + vb);
    if (std::abs(t) > critical_t(p, dof)) {
      ++rejected;
      ADD_FAILURE_AT(__FILE__, __LINE__) << "tile " << i / 3 << " colour " << i % 3 << ": "
                                         << a[i].mean() << " and " << b[i].mean() << ", t = " << t;
    }
  }
  return rejected;
}

class CudaAgainstCpuTest : public CudaTest {
 protected:
  void expect_same(const volume::Volume& volume, const diaphane::v1::Scene& scene,
                   std::uint32_t samples) {
    const auto cpu = make_cpu_engine(0);
    EXPECT_EQ(rejections(tile_moments(*cpu, volume, scene, samples, 1000),
                         tile_moments(*engine_, volume, scene, samples, 2000)),
              0);
  }
};

TEST_F(CudaAgainstCpuTest, AllFeaturesHaveTheSameMean) {
  expect_same(lumpy_volume(40, 30, 25), full_scene(), kMany);
}

TEST_F(CudaAgainstCpuTest, EveryVariantHasTheSameMean) {
  const auto volume = lumpy_volume(20, 18, 17);
  for (int lights = 0; lights <= 2; ++lights) {
    for (const bool sky : {false, true}) {
      for (const double g : {0.0, -0.6}) {
        auto scene = full_scene();
        scene.mutable_phase()->set_g(g);
        if (!sky) scene.mutable_lights()->DeleteSubrange(2, 1);
        scene.mutable_lights()->DeleteSubrange(lights, 2 - lights);
        SCOPED_TRACE(std::to_string(lights) + " rectangles, sky " + std::to_string(sky) + ", g " +
                     std::to_string(g));
        expect_same(volume, scene, kFew);
      }
    }
  }
}

TEST_F(CudaAgainstCpuTest, LabelsHaveTheSameMean) {
  auto volume = lumpy_volume(40, 30, 25);
  test::mark(volume, [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return x < 20 ? 1 : y > 15 ? 2 : z > 12 ? 3 : 0;
  });
  auto scene = full_scene();
  for (const std::uint32_t number : {10, 20, 30}) scene.add_labels()->set_number(number);
  scene.mutable_labels(0)->set_opacity(0.3);
  test::set(scene.mutable_labels(1)->mutable_colour(), 0.9, 0.2, 0.1);
  scene.mutable_labels(2)->set_opacity(0);
  expect_same(volume, scene, kFew);
}

TEST_F(CudaAgainstCpuTest, TwoScansHaveTheSameMean) {
  const auto first = lumpy_volume(40, 30, 25);
  const auto second =
      test::make_volume({14, 11, 9}, {2.2, 2.4, 2.5},
                        [](double x, double y, double) { return 100 + 70 * x + 12 * std::cos(y); });
  const auto cpu = make_cpu_engine(0);
  for (const bool split : {false, true}) {
    auto scene = full_scene();
    auto& overlay = *scene.mutable_overlay();
    test::add_channel(*overlay.mutable_transfer_function(), {{100, 0}, {1000, 1}, {3000, 1}}, 0.1,
                      0.3, 0.9);
    overlay.mutable_transfer_function()->set_extinction_per_mm(0.2);
    overlay.set_share(0.5);
    if (split) {
      overlay.set_mode(diaphane::v1::Overlay::SPLIT);
      overlay.set_split(0.45);
    }
    SCOPED_TRACE(split ? "split" : "mixed");
    const Method method{.walk = Walk::kTracking};
    EXPECT_EQ(rejections(tile_moments(*cpu, first, scene, kMany, 1000, method, &second),
                         tile_moments(*engine_, first, scene, kMany, 2000, method, &second)),
              0);
  }
}

TEST_F(CudaAgainstCpuTest, HighlightHasTheSameMean) {
  auto scene = full_scene();
  scene.mutable_highlight()->set_radius(9);
  test::set(scene.mutable_highlight()->mutable_colour(), 0.1, 0.3, 1);
  const auto volume = lumpy_volume(40, 30, 25);
  const auto cpu = make_cpu_engine(0);
  const auto expected = tile_moments(*cpu, volume, scene, kFew, 1000);
  for (const Walk walk : {Walk::kExact, Walk::kTracking}) {
    EXPECT_EQ(
        rejections(expected, tile_moments(*engine_, volume, scene, kFew, 2000, {.walk = walk})), 0);
  }
}

TEST_F(CudaAgainstCpuTest, LightsOfEveryShapeHaveTheSameMean) {
  auto scene = full_scene();
  const auto colour = [](diaphane::v1::Rgb* c) {
    c->set_r(6);
    c->set_g(4);
    c->set_b(3);
  };
  auto* disk = scene.add_lights()->mutable_disk();
  disk->mutable_centre()->set_x(40);
  disk->mutable_normal()->set_x(-1);
  disk->set_radius(12);
  colour(disk->mutable_radiance());
  auto* sphere = scene.add_lights()->mutable_sphere();
  sphere->mutable_centre()->set_y(-45);
  sphere->set_radius(10);
  colour(sphere->mutable_radiance());
  auto* point = scene.add_lights()->mutable_sphere();
  point->mutable_centre()->set_z(50);
  colour(point->mutable_radiance());
  scene.mutable_lights(scene.lights_size() - 1)->set_intensity(300);
  auto* box = scene.add_lights()->mutable_box();
  box->mutable_corner()->set_z(-60);
  box->mutable_u()->set_x(20);
  box->mutable_v()->set_y(20);
  box->mutable_w()->set_z(15);
  colour(box->mutable_radiance());
  // Without PNG support, the lights have no texture.
  const std::string picture = test::png(16, 8, [](std::uint32_t i, std::uint32_t j) {
    const bool spot = i == 11 && j == 2;
    return spot ? test::Rgb8{255, 240, 200}
                : test::Rgb8{static_cast<std::uint8_t>(9 * i), 60,
                             static_cast<std::uint8_t>(20 * j)};
  });
  if (!picture.empty()) {
    disk->mutable_texture()->set_picture(picture);
    sphere->mutable_texture()->set_picture(picture);
    auto* sky = scene.add_lights()->mutable_environment();
    colour(sky->mutable_radiance());
    sky->mutable_texture()->set_picture(picture);
    scene.mutable_lights(scene.lights_size() - 1)->set_camera_locked(true);
  }
  for (const double g : {0.0, 0.6}) {
    scene.mutable_phase()->set_g(g);
    expect_same(lumpy_volume(40, 30, 25), scene, kMany);
  }
}

/// The first scene has a lens, a clip plane and grey slices. The second has parallel rays, a plane
/// that also cuts light, and coloured slices.
TEST_F(CudaAgainstCpuTest, CameraClipAndSlicesHaveTheSameMean) {
  for (const bool second : {false, true}) {
    auto scene = full_scene();
    scene.mutable_camera()->set_aperture_radius(3);
    scene.mutable_camera()->set_orthographic_height(second ? 45 : 0);
    auto* plane = scene.mutable_clip()->add_planes();
    plane->mutable_point()->set_y(-2);
    plane->mutable_normal()->set_y(-0.8);
    plane->mutable_normal()->set_z(0.5);
    scene.mutable_clip()->set_cuts_light(second);
    auto* slices = scene.mutable_slices();
    slices->mutable_coronal()->set_shown(true);
    slices->mutable_coronal()->set_position(3);
    slices->mutable_axial()->set_shown(true);
    slices->set_window_centre(500);
    slices->set_window_width(1200);
    if (second) slices->set_colouring(diaphane::v1::Slices::TRANSFER);
    SCOPED_TRACE(second ? "parallel rays" : "perspective");
    expect_same(lumpy_volume(40, 30, 25), scene, kFew);
  }
}

/// The engines meter different samples. Over 64 x 48 pixels and three colours, their means differ
/// by far less than a twentieth of a stop.
TEST_F(CudaAgainstCpuTest, AutomaticExposureIsTheSame) {
  const auto cpu = make_cpu_engine(0);
  const auto volume = lumpy_volume(40, 30, 25);
  for (const double intensity : {1.0 / 64, 1024.0}) {
    auto scene = full_scene();
    for (auto& light : *scene.mutable_lights()) light.set_intensity(intensity);
    scene.mutable_display()->set_automatic_exposure(true);
    for (const std::uint32_t samples : {1u, kMany}) {
      std::vector<double> stops;
      std::vector<PictureRgb8> shown(2);
      for (Engine* engine : {cpu.get(), engine_.get()}) {
        auto one = engine->renderer(engine->load(volume).value(), 1, 0).value();
        ASSERT_TRUE(render_all(*one, scene, kCanvas, samples));
        ASSERT_TRUE(one->display(shown[stops.size()]));
        stops.push_back(one->progress().stops);
      }
      EXPECT_NE(stops[0], 0);
      EXPECT_NEAR(stops[0], stops[1], samples == 1 ? 0.5 : 0.05);
      const auto brightness = [](const PictureRgb8& picture) {
        return std::accumulate(picture.pixels.begin(), picture.pixels.end(), 0.0) /
               static_cast<double>(picture.pixels.size());
      };
      if (samples > 1) EXPECT_NEAR(brightness(shown[0]), brightness(shown[1]), 2);
    }
  }
}

TEST_F(CudaAgainstCpuTest, DenseSceneHasTheSameMean) {
  auto scene = full_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(100);
  expect_same(lumpy_volume(33, 9, 1), scene, kFew);
}

/// One sample of the exact walk is dozens of rays, so a few samples are enough. The CPU uses
/// tracking, so that the walk is compared with a different method.
TEST_F(CudaAgainstCpuTest, ExactWalkMatchesTracking) {
  const auto cpu = make_cpu_engine(0);
  const auto volume = lumpy_volume(40, 30, 25);
  EXPECT_EQ(rejections(tile_moments(*cpu, volume, full_scene(), kFew, 5000),
                       tile_moments(*engine_, volume, full_scene(), 4, 6000,
                                    Method{.walk = Walk::kExact})),
            0);
}

TEST_F(CudaAgainstCpuTest, TestDetectsABiasOfTwoPercent) {
  const auto volume = lumpy_volume(40, 30, 25);
  auto brighter = full_scene();
  for (auto& light : *brighter.mutable_lights()) {
    if (!light.has_rectangle()) continue;
    auto* radiance = light.mutable_rectangle()->mutable_radiance();
    radiance->set_r(1.02 * radiance->r());
    radiance->set_g(1.02 * radiance->g());
    radiance->set_b(1.02 * radiance->b());
  }
  const auto a = tile_moments(*engine_, volume, full_scene(), kMany, 3000);
  const auto b = tile_moments(*engine_, volume, brighter, kMany, 4000);
  int apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double t = (b[i].mean() - a[i].mean()) / std::sqrt(a[i].variance() + b[i].variance());
    apart += t > critical_t(sidak(kAlpha, a.size()), kRuns - 1);
  }
  EXPECT_GT(apart, 0);
}

}  // namespace
}  // namespace diaphane::render::cuda
