// Slices show voxel values exactly. They are compared with trilinear interpolation and planes in
// world space in double precision: behind matter, in front of matter, inside matter, and alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/film/tone.h"
#include "renderd/kernel/estimator.h"
#include "renderd/scene/clip_slices.h"
#include "tests/support/renderd/optics.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr Features kSlices = Features{}.with(Feature::kSlices);

volume::Volume smooth_volume() {
  return test::make_volume({30, 26, 18}, {1, 1.3, 1.9}, [](double x, double y, double z) {
    return 1000 * std::sin(0.4 * x) * std::cos(0.3 * y) + 40 * z - 200;
  });
}

/// Three slices without matter, before a background of 0.25.
diaphane::v1::Scene slices_alone() {
  diaphane::v1::Scene scene = test::skull_scene();
  auto* s = scene.mutable_slices();
  test::show(s->mutable_sagittal(), 3.3);
  test::show(s->mutable_coronal(), -4.1);
  test::show(s->mutable_axial(), 2.2);
  s->set_window_centre(150);
  s->set_window_width(1900);
  s->set_alone(true);
  test::set(scene.mutable_display()->mutable_background(), 0.25, 0.25, 0.25);
  scene.mutable_display()->set_show_environment(false);
  return scene;
}

/// Computes what the three slices of slices_alone show at a point of the picture, in double
/// precision: voxel indices on the nearest slice, or nothing. `axis[i]` is the voxel axis of slice
/// i, and `sign[i]` its direction.
struct Expected {
  bool found = false;
  Double3 index{};
  double margin = 1e9;  ///< distance in mm to the next slice or to the edge of the volume
};
Expected expected_slice(const volume::Volume& v, const diaphane::v1::Scene& scene, const int* axis,
                        const double* sign, double x, double y, Canvas canvas) {
  const test::WorldCamera camera(scene.camera());
  const double tangent = std::tan(scene.camera().vertical_fov_degrees() * std::numbers::pi / 360);
  const double a = (2 * x / canvas.width - 1) * tangent * canvas.width / canvas.height;
  const double b = (1 - 2 * y / canvas.height) * tangent;
  const Double3 direction = camera.forward + camera.right * a + camera.up * b;
  const auto& s = scene.slices();
  const double position[3] = {s.sagittal().position(), s.coronal().position(),
                              s.axial().position()};
  const auto& d = v.header.direction;
  const auto index_of = [&](Double3 w) {
    double out[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const double mm = d[k] * w.x + d[3 + k] * w.y + d[6 + k] * w.z;
      out[k] = mm / v.header.spacing[k] + 0.5 * v.header.size[k];
    }
    return Double3{out[0], out[1], out[2]};
  };
  Expected best;
  double nearest = 1e9;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(axis[i]);
    const Double3 along = Double3{d[k], d[3 + k], d[6 + k]} * sign[i];
    const double t = (position[i] - dot(camera.eye, along)) / dot(direction, along);
    const Double3 index = index_of(camera.eye + direction * t);
    double margin = 1e9;
    for (int other = 0; other < 3; ++other) {
      const double size = v.header.size[static_cast<std::size_t>(other)];
      if (other != axis[i]) margin = std::min({margin, index[other], size - index[other]});
    }
    if (margin < 0) {
      best.margin = std::min(best.margin, -margin);
      continue;
    }
    best.margin = std::min({best.margin, margin, std::abs(t - nearest) * length(direction)});
    if (t >= nearest) continue;
    nearest = t;
    best.found = true;
    best.index = index;
  }
  return best;
}

void expect_exact(const volume::Volume& v, const int* axis, const double* sign) {
  const Canvas canvas{64, 48};
  for (const double exposure : {0.0, -3.0, 5.0}) {
    diaphane::v1::Scene scene = slices_alone();
    scene.mutable_display()->set_exposure(exposure);
    const test::Prepared p(v, scene, canvas);
    ASSERT_EQ(p.scene().features, kSlices);
    const auto view = p.view();
    int shown = 0, background = 0;
    Random random(4, 0, 0);
    for (int i = 0; i < 5000; ++i) {
      const float x = 64 * random.one(), y = 48 * random.one();
      const Expected e = expected_slice(v, scene, axis, sign, static_cast<double>(x),
                                        static_cast<double>(y), canvas);
      if (e.margin < 1e-3) continue;
      const PrimaryHit primary = primary_hit<kSlices>(view, camera_ray<kSlices>(view, x, y), {});
      ASSERT_EQ(primary.slice, e.found) << x << " " << y;
      EXPECT_FALSE(primary.span.begin < primary.span.end) << "no matter is traced";
      if (!e.found) {
        ++background;
        EXPECT_EQ(primary.background.x, 0.25f);
        continue;
      }
      ++shown;
      const double value = test::value_at(v, e.index);
      const double grey = std::clamp((value - (150 - 950)) / 1900, 0.0, 1.0);
      const double displayed =
          static_cast<double>(tone(primary.background.x * static_cast<float>(std::exp2(exposure))));
      ASSERT_NEAR(displayed, grey, 0.1 / 255) << "value " << value;
    }
    EXPECT_GT(shown, 500);
    EXPECT_GT(background, 500);
  }
}

TEST(Slices, ShowInterpolatedVoxelsRegardlessOfExposure) {
  const int axis[] = {0, 1, 2};
  const double sign[] = {1, 1, 1};
  expect_exact(smooth_volume(), axis, sign);
  expect_exact(test::tilt(smooth_volume()), axis, sign);
}

TEST(Slices, FollowThePatientAxesForAnyVoxelOrder) {
  volume::Volume v = smooth_volume();
  // Voxel axes: x points to the head, y to the patient's right, z to the front; the frame is
  // right-handed.
  v.header.direction = {0, -1, 0, 0, 0, -1, 1, 0, 0};
  const PatientAxes axes = patient_axes(v.header);
  EXPECT_EQ(axes.voxel_axis[0], 1);
  EXPECT_EQ(axes.voxel_axis[1], 2);
  EXPECT_EQ(axes.voxel_axis[2], 0);
  const int axis[] = {1, 2, 0};
  const double sign[] = {-1, -1, 1};
  expect_exact(v, axis, sign);
}

/// Tests the display bytes of the whole engine.
TEST(Slices, ShowWindowedGreyRegardlessOfExposureAndCurve) {
  const auto engine = make_cpu_engine(1);
  const auto volume = engine->load(test::constant_volume(8, 300)).value();
  for (const double exposure : {-6.0, 0.0, 0.7, 8.0}) {
    for (const double width : {400.0, 900.0, 1e5}) {
      diaphane::v1::Scene scene = slices_alone();
      test::set_camera(scene, 0, -30, 0, 5);
      test::show(scene.mutable_slices()->mutable_coronal(), -3);
      scene.mutable_slices()->set_window_centre(250);
      scene.mutable_slices()->set_window_width(width);
      scene.mutable_display()->set_exposure(exposure);
      scene.mutable_display()->set_curve(width < 600 ? diaphane::v1::Display::FILMIC
                                                     : diaphane::v1::Display::LINEAR);
      const auto renderer = engine->renderer(volume, 1, 0).value();
      ASSERT_TRUE(renderer->set_scene(scene, {8, 8}));
      ASSERT_TRUE(renderer->render(4, nullptr));
      PictureRgb8 picture;
      ASSERT_TRUE(renderer->display(picture));
      const double grey = std::clamp((300 - 250) / width + 0.5, 0.0, 1.0);
      for (const std::uint8_t byte : picture.pixels) ASSERT_NEAR(byte, 255 * grey, 1);
      EXPECT_LT(renderer->progress().error, 1e-5) << "no noise";
    }
  }
}

TEST(Slices, TransferColouringShowsOpacityTimesColour) {
  diaphane::v1::Scene scene = slices_alone();
  scene.mutable_slices()->set_colouring(diaphane::v1::Slices::TRANSFER);
  scene.mutable_display()->set_exposure(2);
  auto* function = scene.mutable_transfer_function();
  function->clear_channels();
  test::add_channel(*function, {{0, 0}, {1000, 0.8}}, 0.9, 0.5, 0.1);
  test::add_channel(*function, {{400, 0}, {600, 0.6}, {1000, 0}}, 0.1, 0.6, 0.9);
  for (const double value : {-50.0, 100.0, 500.0, 600.0, 950.0}) {
    const test::Prepared p(test::constant_volume(8, value), scene);
    const Float3 shown = slice_radiance(p.view(), static_cast<float>(value)) * 4.0f;
    const Material m = material_at(*function, value);
    for (int c = 0; c < 3; ++c) {
      const double mean = m.weight > 0 ? m.weighted_albedo[c] / m.weight : 0;
      EXPECT_NEAR(static_cast<double>(shown[c]), m.opacity * mean, 1e-4) << value;
    }
  }
}

/// A cube of 10 mm in the centre of an empty volume of 20 mm, with a slice at `slice_at`.
diaphane::v1::Scene cube_scene(double extinction, double slice_at) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{500, 0}, {501, 1}, {2000, 1}}, 0, 0, 0);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  test::add_lamp(scene, 0, 0, 40, 10, 5);
  test::set_camera(scene, 0, -500, 0, 0.3);
  test::show(scene.mutable_slices()->mutable_coronal(), slice_at);
  scene.mutable_slices()->set_window_centre(0);
  scene.mutable_slices()->set_window_width(100);
  scene.mutable_display()->set_exposure(-1);
  return scene;
}
volume::Volume cube_volume() {
  return test::make_volume({20, 20, 20}, {1, 1, 1}, [](double x, double y, double z) {
    const auto in = [](double v) { return v > 5 && v < 15; };
    return in(x) && in(y) && in(z) ? 1000 : 20;  // outside, the slice has a grey of 0.7
  });
}
constexpr Features kLitSlices = kSlices.with(Feature::kAreaLights);
const double kGreyRadiance = 2 * std::pow(0.7, 2.2);

TEST(Slices, OccludeAndAreOccludedByOpaqueMedium) {
  const test::Prepared behind(cube_volume(), cube_scene(1e4, 8));
  const test::Prepared before(cube_volume(), cube_scene(1e4, -8));
  for (std::uint64_t i = 0; i < 10; ++i) {
    for (std::uint32_t y = 0; y < 16; ++y) {
      const Sample hidden = estimate<kLitSlices>(behind.view(), y, y, i);
      EXPECT_EQ(hidden.radiance.x, 0) << "black matter";
      EXPECT_TRUE(hidden.hit_medium);
      const Sample seen = estimate<kLitSlices>(before.view(), y, y, i);
      EXPECT_NEAR(static_cast<double>(seen.radiance.x), kGreyRadiance, 1e-5);
      EXPECT_TRUE(seen.hit_medium) << "the error counts such pixels";
    }
  }
}

/// Black matter in front of a slice dims the slice by its transmittance: about 10 mm of full
/// extinction between two ramps. The significance is 1e-3.
TEST(Slices, ThinMediumDimsSliceByItsTransmittance) {
  const test::Prepared p(cube_volume(), cube_scene(0.1, 8), {4, 4});
  test::Moments lean, general;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      lean.add(static_cast<double>(estimate<kLitSlices>(p.view(), k, k, i).radiance.x));
      general.add(static_cast<double>(estimate<kAllFeatures>(p.view(2), k, k, i).radiance.x));
    }
  }
  // The ramp from 20 to 1000 passes 500.5 after 0.49 of the distance between two voxels.
  const double thickness = 10 + 2 * (0.5 - (500.5 - 20) / 980);
  const double exact = kGreyRadiance * std::exp(-0.1 * thickness);
  const double limit = test::critical_z(test::sidak(kAlpha, 2));
  EXPECT_NEAR(lean.mean, exact, limit * lean.error_of_mean());
  EXPECT_NEAR(general.mean, exact, limit * general.error_of_mean());
}

TEST(Slices, CastNoShadow) {
  diaphane::v1::Scene with = test::skull_scene();
  test::set_camera(with, 0, 120, 0, 30);
  // The slice is above everything visible, between the lamp and the skull.
  test::show(with.mutable_slices()->mutable_axial(), 23.99);
  with.mutable_slices()->set_window_width(1);
  diaphane::v1::Scene without = with;
  without.clear_slices();
  constexpr Features kLit = Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment);
  const test::Prepared a(test::skull_volume(), with), b(test::skull_volume(), without);
  ASSERT_EQ(a.scene().features, kLit.with(Feature::kSlices));
  for (std::uint32_t y = 4; y < 16; ++y) {
    for (std::uint32_t x = 0; x < 16; ++x) {
      const Float3 s = estimate<kLit.with(Feature::kSlices)>(a.view(), x, y, 3).radiance;
      EXPECT_EQ(s.x, estimate<kLit>(b.view(), x, y, 3).radiance.x);
    }
  }
}

TEST(Slices, AreClippedAndVisibleInTheClipFaces) {
  diaphane::v1::Scene scene = slices_alone();
  scene.mutable_slices()->clear_coronal();
  scene.mutable_slices()->clear_axial();
  test::set_camera(scene, 200, 13, 7, 4);
  const auto seen = [&](double high) {
    test::set(scene.mutable_clip()->mutable_box_low(), -20, -5, -5);
    test::set(scene.mutable_clip()->mutable_box_high(), high, 5, 5);
    const test::Prepared p(test::tilt(smooth_volume()), scene, {32, 32});
    int count = 0;
    for (std::uint32_t y = 0; y < 32; ++y) {
      for (std::uint32_t x = 0; x < 32; ++x) {
        count += estimate<kSlices.with(Feature::kClip)>(p.view(), x, y, 0).hit_medium ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_GT(seen(20), 100);
  EXPECT_LT(seen(20), 900) << "the box cuts the slice";
  EXPECT_LT(seen(-5), seen(20));
  // The voxels are not rotated and the slice is in the face of the box. Rounding must not make it
  // ragged.
  scene.mutable_slices()->mutable_sagittal()->set_position(3.3);
  const auto whole = [&](double high) {
    test::set(scene.mutable_clip()->mutable_box_high(), high, 5, 5);
    const test::Prepared p(smooth_volume(), scene, {32, 32});
    std::vector<bool> met;
    for (std::uint32_t i = 0; i < 32 * 32; ++i) {
      met.push_back(estimate<kSlices.with(Feature::kClip)>(p.view(), i % 32, i / 32, 0).hit_medium);
    }
    return met;
  };
  EXPECT_EQ(whole(3.3), whole(15));
}

TEST(Slices, AreCompiledOutOutsideTheVolume) {
  diaphane::v1::Scene scene = test::skull_scene();
  test::show(scene.mutable_slices()->mutable_axial(), 500);
  scene.mutable_slices()->set_window_width(1);
  EXPECT_FALSE(test::Prepared(test::skull_volume(), scene).scene().features.has(Feature::kSlices));
  scene.mutable_slices()->mutable_axial()->set_position(24);
  EXPECT_TRUE(test::Prepared(test::skull_volume(), scene).scene().features.has(Feature::kSlices))
      << "in the face of the box";
  scene.mutable_slices()->set_alone(true);
  const test::Prepared p(test::skull_volume(), scene, {32, 32});
  EXPECT_EQ(p.scene().features, kSlices) << "no lights, no steep matter";
  const Box occupied = p.view().grid.occupied;
  EXPECT_EQ(length(occupied.high - occupied.low), 0);
  for (std::uint32_t i = 0; i < 32 * 32; ++i) {
    const Sample s = estimate<kAllFeatures>(p.view(), i % 32, i / 32, 0);
    EXPECT_TRUE(s.hit_medium || s.radiance.x == 0.5f) << "a slice or the sky";
  }
}

}  // namespace
}  // namespace diaphane::render
