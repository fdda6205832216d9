#include "bench/renderer/synthetic_heart.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "renderd/math/random.h"

namespace diaphane::render::bench {
namespace {

constexpr double kExtent = 300;  // mm
constexpr double kAir = -1000, kLung = -850, kTissue = 40, kMuscle = 110, kBlood = 380, kBone = 700;

double ellipsoid(double x, double y, double z, double a, double b, double c) {
  return std::sqrt(x * x / (a * a) + y * y / (b * b) + z * z / (c * c));
}

/// Returns the value of the parts that stay, at a place in mm from the centre (x to the left, y to
/// the back, z to the head).
double chest(double x, double y, double z) {
  const double body = std::hypot(x / 135, y / 100);
  if (body > 1) return kAir;
  const double rib = std::hypot(x / 125, y / 90);
  if (std::abs(rib - 0.97) < 0.03 && std::sin((z + 0.2 * std::abs(x)) / 4.5) > 0.4) return kBone;
  if (std::hypot(x, y - 72) < 16) return kBone;
  const double lung = ellipsoid(std::abs(x) - 62, y, z, 52, 72, 130);
  return lung < 1 ? kLung : kTissue;
}

/// Returns the value of the heart, or `otherwise` outside. `squeeze` is 0 at rest and 1 when the
/// ventricles are smallest: a cavity keeps 55 % of its radius then, and its wall thickens.
double heart(double x, double y, double z, double squeeze, double otherwise) {
  // The long axis points to the left, forward and down.
  const double u = 0.75 * x - 0.45 * y - 0.48 * z, v = 0.51 * x + 0.86 * y,
               w = 0.41 * x - 0.25 * y + 0.88 * z;
  const double cavity = 1 - 0.45 * squeeze, outside = 1 - 0.12 * squeeze;
  const double left = u - 18;
  if (ellipsoid(left, v, w, 42 * cavity, 24 * cavity, 24 * cavity) < 1) return kBlood;
  if (ellipsoid(left, v, w, 54 * outside, 36 * outside, 36 * outside) < 1) return kMuscle;
  const double right = v + 34;
  if (ellipsoid(u, right, w, 38 * cavity, 20 * cavity, 28 * cavity) < 1) return 0.6 * kBlood;
  if (ellipsoid(u, right, w, 43 * outside, 25 * outside, 33 * outside) < 1) return kMuscle;
  if (std::hypot(u + 45, v) < 13 && w > 0 && w < 90) return kBlood;  // aorta
  return otherwise;
}

}  // namespace

volume::Volume synthetic_heart(std::uint32_t n, std::uint32_t phases) {
  volume::Volume v;
  v.header.size = {n, n, n};
  v.header.spacing.fill(kExtent / n);
  v.header.modality = volume::Modality::kCt;
  v.header.window_center = 200;
  v.header.window_width = 700;
  std::vector<double> squeeze;
  for (std::uint32_t p = 0; p < phases; ++p) {
    const double cycle = static_cast<double>(p) / phases;
    v.header.phases.push_back({volume::PhaseKind::kCycle, 100 * cycle});
    squeeze.push_back(std::pow(std::sin(std::numbers::pi * cycle), 2));
  }
  v.voxels.resize(v.header.total_voxel_count());
  const auto along = [&](std::uint32_t i) { return kExtent * ((i + 0.5) / n - 0.5); };
  const auto fill_slice = [&](std::uint32_t z) {
    for (std::uint32_t y = 0; y < n; ++y) {
      Random random(1, y, z);
      for (std::uint32_t x = 0; x < n; ++x) {
        const double stays = chest(along(x), along(y), along(z));
        std::size_t at = (std::size_t{z} * n + y) * n + x;
        for (const double now : squeeze) {
          const double value = heart(along(x), along(y), along(z), now, stays);
          v.voxels[at] = static_cast<std::int16_t>(std::lround(value + 30 * (random.one() - 0.5)));
          at += v.header.voxel_count();
        }
      }
    }
  };
  const std::uint32_t workers = std::clamp(std::thread::hardware_concurrency(), 1u, n);
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t w = 0; w < workers; ++w) {
      threads.emplace_back([&, w] {
        for (std::uint32_t z = w; z < n; z += workers) fill_slice(z);
      });
    }
  }
  volume::measure(v);
  return v;
}

}  // namespace diaphane::render::bench
