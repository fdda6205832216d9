#include "bench/renderer/stability_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render::bench {

ImageStats image_stats(Engine& engine, const volume::Volume& volume,
                       const diaphane::v1::Scene& scene, Canvas canvas, std::uint32_t samples,
                       StabilityRow& row) {
  ImageStats stats;
  const auto refuse = [&](const Error& error) {
    stats.refused = error.message;
    row.passed = false;
    row.note = error.message;
    return stats;
  };
  auto loaded = engine.load(volume);
  if (!loaded) return refuse(loaded.error());
  // Each picture of the table has its own random numbers.
  const std::uint64_t seed =
      mix64(std::hash<std::string>{}(row.about) + static_cast<std::uint64_t>(row.samples));
  auto renderer = engine.renderer(*loaded, seed, 0);
  if (!renderer) return refuse(renderer.error());
  if (auto set = (*renderer)->set_scene(scene, canvas); !set) return refuse(set.error());
  auto batch = (*renderer)->render(samples, [] { return false; });
  if (!batch) return refuse(batch.error());
  PictureRgbF picture;
  if (auto done = (*renderer)->radiance(picture); !done) return refuse(done.error());
  const double pixels = double{1} * canvas.width * canvas.height;
  row.samples += pixels * batch->samples;
  row.non_finite += batch->dropped_samples;
  stats.smallest = std::numeric_limits<double>::infinity();
  stats.largest = -stats.smallest;
  double squared = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    double pixel = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double x = static_cast<double>(picture.pixels[c]);
      row.non_finite += std::isfinite(x) ? 0 : 1;
      stats.smallest = std::min(stats.smallest, x);
      stats.largest = std::max(stats.largest, x);
      pixel += x / 3;
    }
    stats.mean += pixel / pixels;
    squared += pixel * pixel / pixels;
  }
  const double variance = std::max(squared - stats.mean * stats.mean, 0.0);
  stats.deviation = pixels > 1 ? std::sqrt(variance / (pixels - 1)) : 0.0;
  stats.pixels = std::move(picture.pixels);
  return stats;
}

void note_deviation(double deviation, double limit, const std::string& unit, StabilityRow& row) {
  row.unit = unit;
  row.limit = limit;
  row.deviation = std::max(row.deviation, std::abs(deviation));
  if (!(std::abs(deviation) <= limit)) {  // also true for NaN
    row.passed = false;
    row.deviation = std::isfinite(deviation) ? row.deviation : deviation;
  }
}

void compare(const ImageStats& stats, double expected, StabilityRow& row) {
  if (!stats.refused.empty()) return;
  const double off =
      std::max(std::abs(stats.mean - expected) - kRounding * std::abs(expected), 0.0);
  // If every pixel has the same value, no difference is tolerated.
  const double sigmas = off == 0 ? 0.0 : off / std::max(stats.deviation, 1e-30);
  note_deviation(std::isfinite(stats.mean) ? sigmas : stats.mean, kMostSigmas, "sigma", row);
}

void compare(const ImageStats& a, const ImageStats& b, StabilityRow& row) {
  if (!a.refused.empty() || !b.refused.empty()) return;
  ImageStats both = a;
  both.deviation = std::hypot(a.deviation, b.deviation);
  compare(both, b.mean, row);
}

diaphane::v1::Scene beam(Double3 from, Double3 to, double width) {
  diaphane::v1::Scene scene;
  auto& camera = *scene.mutable_camera();
  test::set(camera.mutable_eye(), from.x, from.y, from.z);
  test::set(camera.mutable_target(), to.x, to.y, to.z);
  const Double3 view = to - from;
  // The world axis that is least aligned with the view.
  const double x = std::abs(view.x), y = std::abs(view.y), z = std::abs(view.z);
  test::set(camera.mutable_up(), x <= y && x <= z ? 1 : 0, y < x && y <= z ? 1 : 0,
            z < x && z < y ? 1 : 0);
  camera.set_orthographic_height(width);
  test::set(scene.mutable_display()->mutable_background(), 1, 1, 1);
  return scene;
}

void set_medium(diaphane::v1::Scene& scene,
                std::initializer_list<std::pair<double, double>> opacity, double extinction) {
  scene.mutable_transfer_function()->clear_channels();
  test::add_channel(*scene.mutable_transfer_function(), opacity);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
}

double length_inside(const volume::Header& h, Double3 from, Double3 to) {
  const Double3 d = normalize(to - from);
  double begin = 0, end = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Double3 a{h.direction[axis], h.direction[3 + axis], h.direction[6 + axis]};
    const double at = dot(a, from), slope = dot(a, d);
    const double half = 0.5 * h.size[axis] * h.spacing[axis];
    if (slope == 0) {
      if (std::abs(at) > half) return 0;
      continue;
    }
    const double first = (-half - at) / slope, second = (half - at) / slope;
    begin = std::max(begin, std::min(first, second));
    end = std::min(end, std::max(first, second));
  }
  return std::max(end - begin, 0.0);
}

}  // namespace diaphane::render::bench
