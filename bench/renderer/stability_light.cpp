// Extremes of light and scattering: a furnace in which everything has radiance 1, and single
// scattering of a small lamp against quadrature.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/renderer/stability_case.h"
#include "renderd/kernel/phase.h"

namespace diaphane::render::bench {
namespace {

std::uint32_t samples_of(const StabilityOptions& options, std::uint32_t full) {
  return std::max(options.quick ? full / 10 : full, 2u);
}

/// Renders matter without absorption in a sky of 1: every pixel is 1, whatever the scattering.
void furnace(Engine& engine, const StabilityOptions& options, const volume::Volume& volume,
             double g, diaphane::v1::Shading::Mode mode, StabilityRow& row) {
  diaphane::v1::Scene scene;
  test::set_camera(scene, 45, 80, 28, 30);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.3);
  test::add_channel(*scene.mutable_transfer_function(), {{-32768, 0.2}, {32767, 1}}, 1, 1, 1);
  test::add_sky(scene, 1);
  scene.mutable_display()->set_show_environment(true);
  scene.mutable_phase()->set_g(g);
  scene.mutable_shading()->set_mode(mode);
  scene.set_bounces(1024);
  compare(image_stats(engine, volume, scene, {24, 24}, samples_of(options, 100), row), 1, row);
}

/// A cube of 16 mm with one value, albedo 0.8 and extinction 0.1 per mm. A beam runs along -y
/// through its centre, and light comes from above.
struct LitBox {
  static constexpr double kHalf = 8, kExtinction = 0.1, kAlbedo = 0.8;
  volume::Volume volume = test::constant_volume(16, 100);
  diaphane::v1::Scene scene;

  LitBox() {
    scene = beam({0, 40, 0}, {0, 0, 0}, 1e-3);
    test::set(scene.mutable_display()->mutable_background(), 0, 0, 0);
    set_medium(scene, {{0, 1}, {200, 1}}, kExtinction);
  }
  diaphane::v1::Light* lamp(double z, double side, double radiance) {
    test::add_lamp(scene, 0, 0, z, side, radiance);
    return scene.mutable_lights(scene.lights_size() - 1);
  }
  /// Returns the single scattering of an intensity of 1 (radiance times area) at height z on the
  /// axis.
  static double from_point(double z) {
    constexpr int kSteps = 100'000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = 2 * kHalf * (i + 0.5) / kSteps, y = kHalf - t;
      const double distance = std::hypot(y, z), cosine = z / distance;
      const double inside = distance * std::min(kHalf / z, 1.0);
      sum += std::exp(-kExtinction * (t + inside)) * cosine / (distance * distance);
    }
    return sum * 2 * kHalf / kSteps * kExtinction * kAlbedo / (4 * std::numbers::pi);
  }
};

void tiny_lamp(Engine& engine, const StabilityOptions& options, double side, StabilityRow& row) {
  LitBox box;
  box.lamp(20, side, 1 / (side * side));
  compare(image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row),
          LitBox::from_point(20), row);
}

/// Compares two radiances. With the same random numbers, the pictures differ only by the factor if
/// nothing is clamped.
void brighter(Engine& engine, const StabilityOptions& options, bool near, StabilityRow& row) {
  ImageStats stats[2];
  for (int i = 0; i < 2; ++i) {
    LitBox box;
    box.lamp(near ? 0.5 : 20, near ? 0.1 : 5, i == 0 ? 1 : 1e12);
    StabilityRow own;
    stats[i] = image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), own);
    row.samples += own.samples;
    row.non_finite += own.non_finite;
  }
  double largest = 0;
  for (std::size_t p = 0; p < stats[0].pixels.size(); ++p) {
    const double a = static_cast<double>(stats[0].pixels[p]) * 1e12;
    const double b = static_cast<double>(stats[1].pixels[p]);
    if (a != b) largest = std::max(largest, std::abs(a - b) / std::max(a, b));
  }
  note_deviation(largest, 1e-4, "relative", row);
  if (stats[0].mean <= 0) row.passed = false;
}

/// Checks that a light at the camera is invisible to it: the picture is the same as from 20 mm
/// further away.
void camera_in_light(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  ImageStats stats[2];
  for (int i = 0; i < 2; ++i) {
    LitBox box;
    auto* light = box.scene.add_lights()->mutable_rectangle();  // in the plane y = 40, faces -y
    test::set(light->mutable_corner(), -5, 40, -5);
    test::set(light->mutable_u(), 10, 0, 0);
    test::set(light->mutable_v(), 0, 0, 10);
    test::set(light->mutable_radiance(), 3, 3, 3);
    test::set(box.scene.mutable_camera()->mutable_eye(), 0, i == 0 ? 40 : 60, 0);
    stats[i] = image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row);
  }
  compare(stats[0], stats[1], row);
  if (stats[0].mean <= 0) row.passed = false;
}

void camera_in_sphere(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  LitBox box;
  auto* sphere = box.scene.add_lights()->mutable_sphere();
  test::set(sphere->mutable_centre(), 0, 40, 0);
  sphere->set_radius(2);
  test::set(sphere->mutable_radiance(), 3, 3, 3);
  const ImageStats inside =
      image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row);
  if (!inside.refused.empty()) return;
  test::set(box.scene.mutable_camera()->mutable_eye(), 0, 60, 0);
  const ImageStats outside =
      image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row);
  compare(inside, outside, row);
}

void black_light(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  LitBox box;
  box.lamp(20, 5, 0);
  const ImageStats stats =
      image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row);
  note_deviation(std::max(stats.largest, -stats.smallest), 0, "absolute", row);
}

/// Checks that a black light beside a bright one changes nothing.
void black_beside_bright(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  LitBox box;
  box.lamp(20, 1e-3, 0);
  box.lamp(20, 1e-3, 1e6);
  compare(image_stats(engine, box.volume, box.scene, {64, 64}, samples_of(options, 60), row),
          LitBox::from_point(20), row);
}

/// Checks lamps that touch the matter or lie in it, where 1 / distance^2 is unbounded. The picture
/// must be finite and positive.
void lamp_inside(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  for (const double z : {8.0, 7.999, 1e-3, 0.0}) {
    for (const double side : {1e-5, 1.0, 100.0}) {
      LitBox box;
      box.lamp(z, side, 1e6);
      const ImageStats stats =
          image_stats(engine, box.volume, box.scene, {16, 16}, samples_of(options, 60), row);
      if (!(stats.smallest >= 0)) row.passed = false;
    }
  }
  note_deviation(static_cast<double>(row.non_finite), 0, "absolute", row);
}

/// Checks the sampler at the limits of its range.
void unit_ends(Engine&, const StabilityOptions&, StabilityRow& row) {
  std::uint64_t bad = 0;
  const float ends[] = {0.0f, 0x1p-33f, 0.5f, 0x1.fffffep-1f, 1.0f};
  const auto check = [&](Float3 d) {
    row.samples += 1;
    bad += is_finite(d) && std::abs(length(d) - 1) < 1e-4f ? 0 : 1;
  };
  for (const float u : ends) {
    for (const float v : ends) {
      check(sample_sphere(u, v));
      for (const double g : {0.0, 0.5, 0.9999, 1 - 1e-7, -0.9999, -(1 - 1e-7)}) {
        for (const Float3 in : {Float3{0, 0, 1}, Float3{0, 0, -1}, Float3{1, 0, 0}}) {
          const auto narrow = static_cast<float>(g);
          const Float3 out = sample_henyey_greenstein(narrow, in, u, v);
          check(out);
          bad += std::isfinite(henyey_greenstein(narrow, in, out)) ? 0 : 1;
        }
      }
    }
  }
  for (const std::uint32_t bits : {0u, 1u, 0x7fffffffu, 0x80000000u, ~0u - 1, ~0u}) {
    row.samples += 2;
    bad += to_unit(bits) > 0 && to_unit(bits) < 1 ? 0 : 1;
    bad += to_exponential(bits) > 0 && to_exponential(bits) < 25 ? 0 : 1;
  }
  row.non_finite = bad;
  row.note = "the functions of kernel/ and math/, compiled for this machine";
  note_deviation(static_cast<double>(bad), 0, "absolute", row);
}

}  // namespace

std::vector<StabilityCase> light_cases() {
  using diaphane::v1::Shading;
  std::vector<StabilityCase> cases;
  for (const double g : {0.0, 0.9, 0.9999, 1 - 1e-7, -0.9999, -(1 - 1e-7)}) {
    char text[64];
    std::snprintf(text, sizeof text, "furnace, g = %.8g", g);
    cases.push_back({text, [g](Engine& e, const StabilityOptions& w, StabilityRow& row) {
                       furnace(e, w, test::skull_volume(), g, Shading::PHASE, row);
                     }});
  }
  for (const auto& [about, mode] :
       {std::pair{"surfaces", Shading::SURFACE}, std::pair{"hybrid shading", Shading::HYBRID}}) {
    cases.push_back({std::string("zero gradient everywhere: furnace, ") + about,
                     [mode = mode](Engine& e, const StabilityOptions& w, StabilityRow& row) {
                       furnace(e, w, test::constant_volume(32, 100), 0, mode, row);
                     }});
    cases.push_back({std::string("furnace, ") + about,
                     [mode = mode](Engine& e, const StabilityOptions& w, StabilityRow& row) {
                       furnace(e, w, test::skull_volume(), 0, mode, row);
                     }});
  }
  for (const double side : {1e-1, 1e-3, 1e-5}) {
    char text[64];
    std::snprintf(text, sizeof text, "lamp of %g mm, against quadrature", side);
    cases.push_back({text, [side](Engine& e, const StabilityOptions& w, StabilityRow& row) {
                       tiny_lamp(e, w, side, row);
                     }});
  }
  cases.push_back({"black light", black_light});
  cases.push_back({"black light beside a bright one", black_beside_bright});
  cases.push_back({"intensity 1e12", [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
                     brighter(e, w, false, row);
                   }});
  cases.push_back(
      {"fireflies are not clamped",
       [](Engine& e, const StabilityOptions& w, StabilityRow& row) { brighter(e, w, true, row); }});
  cases.push_back({"camera in the plane of a lamp", camera_in_light});
  cases.push_back({"camera inside a spherical light", camera_in_sphere});
  cases.push_back({"lamps at and in the matter", lamp_inside});
  cases.push_back({"u = 0 and u = 1 exactly", unit_ends});
  return cases;
}

}  // namespace diaphane::render::bench
