// Two scans in one space. The brute-force estimate of the transmittance and of the colours shares
// no code with the kernel but the map of indices, which volume/alignment_test.cpp tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/kernel/estimator.h"
#include "renderd/kernel/variants.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

/// A turn by 25 degrees about z and a shift.
volume::Matrix turned() {
  const double c = std::cos(0.44), s = std::sin(0.44);
  return {c, -s, 0, 3, s, c, 0, -2, 0, 0, 1, 1.5, 0, 0, 0, 1};
}

volume::Volume first_volume() {
  return test::make_volume({37, 21, 26}, {1, 1.25, 0.75}, [](double x, double y, double z) {
    return 500 + 20 * x + 9 * std::sin(y) * z;
  });
}
/// A smaller scan of other voxels, so that its faces lie inside the first.
volume::Volume second_volume() {
  return test::make_volume({14, 11, 9}, {1.7, 1.4, 1.5}, [](double x, double y, double z) {
    return 100 + 70 * x + 12 * std::cos(y) * z;
  });
}

diaphane::v1::Scene scene_with(double share, double extinction = 0.2) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{0, 0.05}, {1500, 1}}, 0.9, 0.1, 0.2);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  auto& overlay = *scene.mutable_overlay();
  test::add_channel(*overlay.mutable_transfer_function(), {{200, 0}, {1000, 1}, {3000, 1}}, 0.1,
                    0.3, 0.9);
  overlay.mutable_transfer_function()->set_extinction_per_mm(1.5 * extinction);
  overlay.set_share(share);
  test::add_sky(scene, 1);
  test::set_camera(scene, 30, 70, 20, 30);
  return scene;
}

/// The extinctions of both scans at a place (mm from the middle of the first), in double precision.
struct Extinctions {
  double first, second;
};
Extinctions extinctions_at(const test::Prepared& p, const volume::Volume& second,
                           const std::array<double, 3>& index) {
  const auto value = [](const volume::Volume& v, const std::array<double, 3>& at) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<std::size_t, 3> i{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double q = at[axis] - 0.5, low = std::floor(q);
        const int up = corner >> axis & 1;
        weight *= up != 0 ? q - low : 1 - (q - low);
        i[axis] = static_cast<std::size_t>(std::clamp(low + up, 0.0, v.header.size[axis] - 1.0));
      }
      const auto& n = v.header.size;
      sum += weight * v.voxels[i[0] + n[0] * (i[1] + std::size_t{n[1]} * i[2])];
    }
    return sum;
  };
  const auto there =
      volume::moved(volume::between_indices(p.volume().header, second.header, turned()), index);
  Extinctions e{};
  e.first = 0.2 * std::clamp(0.05 + 0.95 * value(p.volume(), index) / 1500, 0.0, 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (there[axis] < 0 || there[axis] > second.header.size[axis]) return e;
  }
  e.second = 0.3 * std::clamp((value(second, there) - 200) / 800, 0.0, 1.0);
  return e;
}

test::Prepared prepared(const diaphane::v1::Scene& scene, Canvas canvas = {16, 16}) {
  return {first_volume(), second_volume(), turned(), scene, canvas};
}

TEST(Overlay, BoundsHoldEverywhere) {
  for (const double share : {0.1, 0.5, 0.8, 1.0}) {
    const test::Prepared p = prepared(scene_with(share));
    const auto view = p.view();
    ASSERT_TRUE(p.scene().features.has(Feature::kOverlay));
    const auto medium = medium_of<kAllFeatures>(view, shares_at<kAllFeatures>(view, 0));
    std::mt19937 generator(7);
    const Int3 n = view.volume.size;
    const auto place = [&](std::int32_t size) {
      return std::uniform_real_distribution<float>(0, static_cast<float>(size))(generator);
    };
    std::size_t both = 0;
    for (int i = 0; i < 100000; ++i) {
      const Float3 at{place(n.x), place(n.y), place(n.z)};
      const float extinction = medium.extinction(view.volume.at(at), at);
      const auto cell = [](float v, float edge) { return static_cast<std::int32_t>(v / edge); };
      const std::int32_t index =
          cell(at.x, 8) + view.grid.size.x * (cell(at.y, 8) + view.grid.size.y * cell(at.z, 8));
      ASSERT_LE(view.grid.cells[index].minorant, extinction);
      ASSERT_GE(view.grid.cells[index].majorant, extinction);
      const Int3 voxels{cell(at.x + 0.5f, 1), cell(at.y + 0.5f, 1), cell(at.z + 0.5f, 1)};
      ASSERT_GE(medium.majorant(voxels, index), extinction);
      both += medium.second_extinction(at) > 0 ? 1 : 0;
    }
    EXPECT_GT(both, 3000u) << "the second scan lies inside the first";
  }
}

TEST(Overlay, TransmittanceIsThatOfBothScansTogether) {
  const test::Prepared p = prepared(scene_with(0.5));
  const volume::Volume second = second_volume();
  const auto view = p.view();
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto& h = p.volume().header;
  constexpr int kRays = 40, kSamples = 20000, kSteps = 4000;
  // Two-sided over all rays together: 1e-3 / 40 each, so 4.2 standard errors.
  constexpr double kErrors = 4.2;
  for (int r = 0; r < kRays; ++r) {
    std::array<double, 3> a{}, b{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      a[axis] = unit(generator) * h.size[axis];
      b[axis] = unit(generator) * h.size[axis];
    }
    const Float3 from{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
    const Float3 to{static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2])};
    const Float3 along = (to - from) * view.spacing;
    const float distance = length(along);
    double depth = 0;
    for (int i = 0; i < kSteps; ++i) {
      std::array<double, 3> at{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis] = a[axis] + (b[axis] - a[axis]) * (i + 0.5) / kSteps;
      const Extinctions e = extinctions_at(p, second, at);
      depth += (e.first + e.second) * static_cast<double>(distance) / kSteps;
    }
    test::Moments moments;
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      Random random(11, static_cast<std::uint32_t>(r), i);
      moments.add(static_cast<double>(tracked_visibility<kAllFeatures>(
          view, shares_at<kAllFeatures>(view, 0), from, along * (1 / distance), distance, random)));
    }
    const double error = std::sqrt(moments.variance() / kSamples);
    // The steps across the second scan's faces are off by at most one step each.
    const double steps = 2 * 0.3 * static_cast<double>(distance) / kSteps;
    EXPECT_NEAR(moments.mean, std::exp(-depth), kErrors * error + steps) << r;
  }
}

TEST(Overlay, CollisionsBelongToEitherScanInProportionToItsExtinction) {
  const test::Prepared p = prepared(scene_with(0.5));
  const volume::Volume second = second_volume();
  const auto view = p.view();
  const auto medium = medium_of<kAllFeatures>(view, shares_at<kAllFeatures>(view, 0));
  // Along the middle line of the second scan, the expected number of collisions with it is the sum
  // of its share of the extinction at each collision.
  const Ray ray{{6.0f, 10.0f, 13.0f}, Float3{1, 0, 0} * view.inverse_spacing};
  double expected = 0, variance = 0;
  int found = 0, wrong = 0;
  for (std::uint64_t i = 0; i < 40000; ++i) {
    Random random(5, 0, i);
    const Collision hit = track<true>(ray, Span{0, 25}, view.grid, medium, random);
    if (!hit.found) continue;
    const Float3 at = ray.at(hit.distance);
    const Extinctions e = extinctions_at(p, second, {at.x, at.y, at.z});
    const double share = e.second / (e.first + e.second);
    expected += share;
    variance += share * (1 - share);
    found += hit.second ? 1 : 0;
    const float value = hit.second ? medium.second_value(at) : view.volume.at(at);
    wrong += hit.value == value ? 0 : 1;
  }
  EXPECT_GT(expected, 2000);
  EXPECT_NEAR(found, expected, 3.9 * std::sqrt(variance)) << "two-sided, 1e-4";
  EXPECT_EQ(wrong, 0);
}

std::vector<float> picture_of(const diaphane::v1::Scene& scene, bool two, Canvas canvas = {24, 24},
                              std::uint32_t samples = 4, std::uint64_t seed = 3) {
  const auto engine = make_cpu_engine(2);
  const auto loaded = engine->load(first_volume()).value();
  const auto renderer = engine->renderer(loaded, seed, 0, {.walk = Walk::kTracking}).value();
  if (two) {
    EXPECT_TRUE(renderer->set_second(engine->load(second_volume()).value(), turned()));
  }
  EXPECT_TRUE(renderer->set_scene(scene, canvas));
  EXPECT_TRUE(renderer->render(samples, nullptr));
  PictureRgbF out;
  EXPECT_TRUE(renderer->radiance(out));
  return out.pixels;
}

TEST(Overlay, CostsNothingIfTheSecondScanIsNotShown) {
  diaphane::v1::Scene without = scene_with(0);
  for (const auto& scene : {scene_with(0), [&] {
                              auto s = scene_with(0.5);
                              s.mutable_overlay()->clear_transfer_function();
                              return s;
                            }()}) {
    const test::Prepared p = prepared(scene);
    EXPECT_FALSE(p.scene().features.has(Feature::kOverlay));
    EXPECT_FALSE(kVariants[variant_for(p.scene().features)].has(Feature::kOverlay));
    EXPECT_TRUE(use_exact_walk(p.scene(), Method{}));
    without.clear_overlay();
    EXPECT_EQ(picture_of(scene, true), picture_of(without, false)) << "bit for bit";
  }
  // A scene with every other feature, and one whose session has no second scan.
  EXPECT_FALSE(kVariants[variant_for(kOneScan)].has(Feature::kOverlay));
  EXPECT_FALSE(kVariants[variant_for(kOneScan.without(Feature::kGuides))].has(Feature::kOverlay));
  EXPECT_EQ(picture_of(scene_with(0.7), false), picture_of(without, false));
}

TEST(Overlay, GeneralKernelRendersScenesOfOneScanAlike) {
  diaphane::v1::Scene scene = scene_with(0);
  const test::Prepared p(first_volume(), scene);
  const auto view = p.view();
  for (std::uint32_t i = 0; i < 256; ++i) {
    const Sample with = estimate<kAllFeatures>(view, i % 16, i / 16, 0);
    const Sample without = estimate<kOneScan>(view, i % 16, i / 16, 0);
    EXPECT_EQ(with.radiance.x, without.radiance.x);
  }
}

TEST(Overlay, TheSecondScanAloneIsThatScanInItsPlace) {
  // The second scan is the first, shifted by whole voxels in a larger box, so both pictures have
  // the same expectation. Welch's t-test of the means of 64 pictures of 12 x 12 pixels.
  volume::Volume small = first_volume();
  volume::Volume empty = test::make_volume({60, 60, 60}, {1, 1.25, 0.75},
                                           [](double, double, double) { return -1000; });
  diaphane::v1::Scene alone = scene_with(0);
  *alone.mutable_transfer_function() = alone.overlay().transfer_function();
  alone.clear_overlay();
  const diaphane::v1::Scene over = scene_with(1);
  const auto engine = make_cpu_engine(2);
  const auto means = [&](bool two) {
    test::Moments moments;
    for (std::uint32_t i = 0; i < 64; ++i) {
      const auto loaded = engine->load(two ? empty : small).value();
      const auto renderer = engine->renderer(loaded, 7 + i, two ? 1000 : 0, {}).value();
      if (two) EXPECT_TRUE(renderer->set_second(engine->load(small).value(), volume::kIdentity));
      EXPECT_TRUE(renderer->set_scene(two ? over : alone, {12, 12}));
      EXPECT_TRUE(renderer->render(8, nullptr));
      PictureRgbF out;
      EXPECT_TRUE(renderer->radiance(out));
      double sum = 0;
      for (const float v : out.pixels) sum += static_cast<double>(v);
      moments.add(sum / static_cast<double>(out.pixels.size()));
    }
    return moments;
  };
  const test::Moments one = means(false), two = means(true);
  const double error = std::sqrt((one.variance() + two.variance()) / 64);
  EXPECT_NEAR(one.mean, two.mean, 3.9 * error) << "two-sided, 1e-4";
  EXPECT_LT(error, 0.01 * one.mean) << "finds a bias of 4%";
}

TEST(Overlay, SplitShowsEitherScanOnItsSide) {
  diaphane::v1::Scene split = scene_with(0);
  split.mutable_overlay()->set_mode(diaphane::v1::Overlay::SPLIT);
  split.mutable_overlay()->set_split(0.5);
  diaphane::v1::Scene first = scene_with(0);
  const diaphane::v1::Scene second = scene_with(1);
  constexpr Canvas kCanvas{24, 24};
  constexpr std::uint32_t kSamples = 64;
  // Columns 0 to 11 and 12 to 23. The means of both halves, of 24 seeds.
  std::array<test::Moments, 2> of_split, of_one;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const auto a = picture_of(split, true, kCanvas, kSamples, seed);
    const std::array<std::vector<float>, 2> b{
        picture_of(first, true, kCanvas, kSamples, 100 + seed),
        picture_of(second, true, kCanvas, kSamples, 200 + seed)};
    for (std::size_t half = 0; half < 2; ++half) {
      double sum_a = 0, sum_b = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        if ((i / 3 % 24 >= 12) != (half == 1)) continue;
        sum_a += static_cast<double>(a[i] * (1.0F + static_cast<float>(i % 3)));
        sum_b += static_cast<double>(b[half][i] * (1.0F + static_cast<float>(i % 3)));
      }
      of_split[half].add(sum_a);
      of_one[half].add(sum_b);
    }
  }
  for (std::size_t half = 0; half < 2; ++half) {
    const double error = std::sqrt((of_split[half].variance() + of_one[half].variance()) / 24);
    EXPECT_NEAR(of_split[half].mean, of_one[half].mean, 4.2 * error) << half;
  }
  EXPECT_GT(std::abs(of_one[0].mean - of_one[1].mean), 100 * std::sqrt(of_one[0].variance() / 24));
}

TEST(Overlay, SharesLeaveThatPartOfTheOpacityOfALayer) {
  for (const double densest : {1e-6, 0.01, 3.0, 100.0}) {
    EXPECT_EQ(extinction_share(0, densest), 0);
    EXPECT_EQ(extinction_share(1, densest), 1);
    for (const double keep : {0.1, 0.5, 0.9}) {
      const double whole = -std::expm1(-densest * 100);
      const double part = -std::expm1(-densest * 100 * extinction_share(keep, densest));
      EXPECT_NEAR(part / whole, keep, 1e-9);
    }
  }
  EXPECT_EQ(extinction_share(0.3, 0), 0.3);
}

TEST(Overlay, SlicesShowTheSecondScanOverTheFirst) {
  diaphane::v1::Scene scene = scene_with(0.5);
  scene.mutable_slices()->mutable_axial()->set_shown(true);
  scene.mutable_slices()->set_alone(true);
  scene.mutable_slices()->set_window_width(1500);
  scene.mutable_slices()->set_window_centre(750);
  const test::Prepared p = prepared(scene);
  const auto view = p.view();
  const auto shown = [&](Float3 place) {
    return slice_radiance_at<kAllFeatures>(view, place, shares_at<kAllFeatures>(view, 0));
  };
  const auto medium = medium_of<kAllFeatures>(view, shares_at<kAllFeatures>(view, 0));
  const Float3 outside{1, 1, 13}, inside{24, 9, 15};
  EXPECT_EQ(medium.second_extinction(outside), 0);
  ASSERT_GT(medium.second_extinction(inside), 0);
  EXPECT_EQ(shown(outside).x, slice_radiance(view, view.volume.at(outside)).x);
  const float opacity = medium.second_extinction(inside) / 0.3f;
  const float grey = slice_radiance(view, view.volume.at(inside)).x;
  EXPECT_NEAR(shown(inside).z, grey * (1 - opacity) + 0.9f * opacity, 1e-4);
  EXPECT_NEAR(shown(inside).x, grey * (1 - opacity) + 0.1f * opacity, 1e-4);
}

TEST(Overlay, VolumesOfAnotherEngineAreRefused) {
  const auto one = make_cpu_engine(1);
  class Other final : public DeviceVolume {
   public:
    const volume::Header& header() const override { return header_; }
    std::uint64_t device_bytes() const override { return 0; }

   private:
    volume::Header header_;
  };
  const auto renderer = one->renderer(one->load(first_volume()).value(), 1, 0).value();
  EXPECT_EQ(renderer->set_second(std::make_shared<Other>(), volume::kIdentity).error().code,
            ErrorCode::kInternal);
  EXPECT_TRUE(renderer->set_second(nullptr, volume::kIdentity));
}

}  // namespace
}  // namespace diaphane::render
