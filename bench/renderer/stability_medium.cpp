// Extinction: the transmittance of a beam against Beer and Lambert.
#include <algorithm>
#include <cmath>

#include "bench/renderer/stability_case.h"

namespace diaphane::render::bench {
namespace {

constexpr Canvas kCanvas{64, 64};

std::uint32_t samples_of(const StabilityOptions& options, std::uint32_t full) {
  return std::max(options.quick ? full / 10 : full, 2u);
}

/// Sends a beam through a box of one value, off its centre and in a direction that is parallel to
/// no axis.
void through_a_box(Engine& engine, const StabilityOptions& options, double extinction, double depth,
                   std::uint32_t samples, StabilityRow& row) {
  constexpr double kSmallestVoxel = 1e-6;  // mm, the smallest that the renderer accepts
  const double edge = std::max(depth / extinction, kSmallestVoxel);
  const auto n = static_cast<std::uint32_t>(std::min(edge / kSmallestVoxel, 16.0));
  const volume::Volume v = test::constant_volume(n, 100, edge / n);
  const Double3 from{2 * edge, 1.1 * edge, 0.7 * edge};
  diaphane::v1::Scene scene = beam(from, {0.02 * edge, 0, 0}, 1e-4 * edge);
  set_medium(scene, {{0, 1}, {200, 1}}, extinction);
  const double length = length_inside(v.header, from, {0.02 * edge, 0, 0});
  compare(image_stats(engine, v, scene, kCanvas, samples_of(options, samples), row),
          std::exp(-extinction * length), row);
}

/// Sends a beam between columns of the densest matter, through matter of a millionth of its
/// density.
void between_spikes(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  const volume::Volume v =
      test::make_volume({48, 48, 48}, {1, 1, 1}, [](double x, double y, double) {
        return std::fmod(x, 4) < 1 && std::fmod(y, 4) < 1 ? 30000 : 0;
      });
  // In each block of four voxels, voxel (2, 2) has no column beside it.
  const Double3 from{2.5 - 24 + 20, 2.5 - 24 + 20, 60};
  diaphane::v1::Scene scene = beam(from, {from.x, from.y, 0}, 0.2);
  set_medium(scene, {{0, 1e-6}, {30000, 1}}, 1e4);
  compare(image_stats(engine, v, scene, kCanvas, samples_of(options, 40), row),
          std::exp(-1e-2 * 48), row);
}

/// Interpolates in double precision, by the definition of the model.
double value_at(const volume::Volume& v, Double3 p) {
  double weight[3][2];
  std::int64_t first[3];
  const double place[3] = {p.x, p.y, p.z};
  for (int a = 0; a < 3; ++a) {
    const double most = static_cast<double>(v.header.size[static_cast<std::size_t>(a)]) - 1;
    const double f = std::clamp(place[a] - 0.5, 0.0, most);
    first[a] =
        std::min<std::int64_t>(static_cast<std::int64_t>(f), static_cast<std::int64_t>(most));
    weight[a][1] = f - static_cast<double>(first[a]);
    weight[a][0] = 1 - weight[a][1];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::size_t at[3];
    double w = 1;
    for (int a = 0; a < 3; ++a) {
      const int bit = corner >> a & 1;
      const auto last = static_cast<std::int64_t>(v.header.size[static_cast<std::size_t>(a)]) - 1;
      at[a] = static_cast<std::size_t>(std::min(first[a] + bit, last));
      w *= weight[a][bit];
    }
    sum += w * v.voxels[at[0] + v.header.size[0] * (at[1] + v.header.size[1] * at[2])];
  }
  return sum;
}

/// Sends beams through thin spikes in the transfer function and in the volume. The expected optical
/// depth is computed by the midpoint rule in double precision.
void through_random_spikes(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  Random random(77, 1, 2);
  const volume::Volume v =
      test::make_volume({40, 36, 28}, {1, 1, 1.3}, [&](double, double, double) {
        return random.one() < 0.04f ? 30000.0 : 200.0 * static_cast<double>(random.one());
      });
  const auto opacity = [](double x) {  // a spike of width 60 at 9000, a ramp to the top
    if (x < 200) return 1e-6;
    if (x < 8970) return 1e-6;
    if (x < 9000) return 1e-6 + (x - 8970) / 30 * (0.5 - 1e-6);
    if (x < 9030) return 0.5 - (x - 9000) / 30 * (0.5 - 1e-6);
    if (x < 29000) return 1e-6;
    return 1e-6 + (x - 29000) / 1000 * (1 - 1e-6);
  };
  for (int ray = 0; ray < 8; ++ray) {
    const double a = 0.7 * ray + 0.1;
    const Double3 from{60 * std::cos(a), 60 * std::sin(a), 9.0 * (ray - 4)};
    const Double3 to{1.5 * ray - 6, 2.0 - ray, 0.3 * ray};
    diaphane::v1::Scene scene = beam(from, to, 1e-4);
    set_medium(scene,
               {{0, 1e-6}, {8970, 1e-6}, {9000, 0.5}, {9030, 1e-6}, {29000, 1e-6}, {30000, 1}}, 20);
    const Double3 d = normalize(to - from);
    constexpr int kSteps = 400'000;
    double depth = 0;
    for (int i = 0; i < kSteps; ++i) {
      const Double3 p = from + d * (120.0 * (i + 0.5) / kSteps);
      const Double3 index{p.x + 20, p.y + 18, (p.z + 18.2) / 1.3};
      if (index.x < 0 || index.y < 0 || index.z < 0 || index.x > 40 || index.y > 36 ||
          index.z > 28) {
        continue;
      }
      depth += 20 * opacity(value_at(v, index)) * 120 / kSteps;
    }
    const ImageStats stats = image_stats(engine, v, scene, {32, 32}, samples_of(options, 200), row);
    // The renderer's table has nodes of finite width, so a bend of the function is off by about
    // 1e-3.
    const double expected = std::exp(-depth);
    const double off = std::max(std::abs(stats.mean - expected) - 2e-3 * expected, 0.0);
    note_deviation(off / std::max(stats.deviation, 1e-9), kMostSigmas, "sigma", row);
  }
}

void of_spacing(Engine& engine, const StabilityOptions& options, std::array<double, 3> spacing,
                bool oblique, double far, StabilityRow& row) {
  volume::Volume v = test::constant_volume(16, 100);
  v.header.spacing = spacing;
  if (oblique) {  // rotated by 50 degrees about (1, 2, 3)
    const Double3 axis = normalize(Double3{1, 2, 3});
    const double c = std::cos(0.8727), s = std::sin(0.8727);
    const double k[3] = {axis.x, axis.y, axis.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double cross_part = i == j ? 0 : ((j + 3 - i) % 3 == 1 ? -1 : 1) * k[3 - i - j] * s;
        v.header.direction[3 * i + j] = (i == j ? c : 0) + (1 - c) * k[i] * k[j] + cross_part;
      }
    }
  }
  const double edge = 16 * std::max({spacing[0], spacing[1], spacing[2]});
  const double thin = 16 * std::min({spacing[0], spacing[1], spacing[2]});
  const double distance = std::max(far, 2 * edge);
  for (const Double3 way : {Double3{1, 0.3, 0.2}, Double3{-0.1, 1, 0.05}, Double3{0.2, -0.1, -1}}) {
    const Double3 from = normalize(way) * distance;
    const Double3 to = along(1, 0.1 * thin);
    const double length = length_inside(v.header, from, to);
    diaphane::v1::Scene scene = beam(from, to, 1e-4 * thin);
    set_medium(scene, {{0, 1}, {200, 1}}, 1 / length);
    compare(image_stats(engine, v, scene, kCanvas, samples_of(options, 60), row), std::exp(-1.0),
            row);
  }
}

void of_shape(Engine& engine, const StabilityOptions& options, std::array<std::uint32_t, 3> size,
              double value, StabilityRow& row) {
  const volume::Volume v =
      test::make_volume(size, {1, 1, 1}, [value](double, double, double) { return value; });
  const Double3 from{31, 17, 23}, to{0.1, 0.05, 0.02};
  diaphane::v1::Scene scene = beam(from, to, 1e-4);
  const double length = length_inside(v.header, from, to);
  set_medium(scene, {{-32768, 1}, {32767, 1}}, 0.8 / length);
  compare(image_stats(engine, v, scene, kCanvas, samples_of(options, 60), row), std::exp(-0.8),
          row);
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

}  // namespace

std::vector<StabilityCase> medium_cases() {
  std::vector<StabilityCase> cases;
  const auto add = [&](std::string about, auto measure) {
    cases.push_back({std::move(about), measure});
  };
  for (const double extinction : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    add("density " + number(extinction) + " per mm",
        [extinction](Engine& e, const StabilityOptions& w, StabilityRow& row) {
          through_a_box(e, w, extinction, 0.7, 100, row);
        });
  }
  for (const double depth : {1e-6, 1e-4, 1e-2, 1.0, 8.0, 1e4, 1e7}) {
    add("optical depth " + number(depth),
        [depth](Engine& e, const StabilityOptions& w, StabilityRow& row) {
          through_a_box(e, w, depth > 1e4 ? 1e3 : 1, depth, depth < 1e-5 ? 5000 : 250, row);
        });
  }
  add("spikes: majorant ratio 1e6, between columns", between_spikes);
  add("spikes in function and volume, against quadrature", through_random_spikes);
  const std::array<double, 3> spacings[] = {{1, 1, 20}, {20, 1, 1}, {1, 1, 100}, {0.03, 1, 30}};
  for (const auto& s : spacings) {
    for (const bool oblique : {false, true}) {
      add("spacing " + number(s[0]) + ":" + number(s[1]) + ":" + number(s[2]) +
              (oblique ? ", oblique axes" : ""),
          [=](Engine& e, const StabilityOptions& w, StabilityRow& row) {
            of_spacing(e, w, s, oblique, 0, row);
          });
    }
  }
  add("camera 1e6 mm away", [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
    of_spacing(e, w, {1, 1, 1}, false, 1e6, row);
  });
  add("camera 1e6 mm away, spacing 1:20, oblique axes",
      [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
        of_spacing(e, w, {1, 1, 20}, true, 1e6, row);
      });
  const std::array<std::uint32_t, 3> sizes[] = {{1, 1, 1},   {1, 16, 16}, {16, 1, 16},
                                                {16, 16, 1}, {8, 8, 8},   {9, 17, 16}};
  for (const double value : {-32768.0, 0.0, 32767.0}) {
    add("constant " + number(value) + ", 1x1x1 to 9x17x16 voxels",
        [=](Engine& e, const StabilityOptions& w, StabilityRow& row) {
          for (const auto& size : sizes) of_shape(e, w, size, value, row);
        });
  }
  add("empty function", [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
    diaphane::v1::Scene scene = beam({30, 20, 10}, {0, 0, 0}, 40);
    set_medium(scene, {{-32768, 0}, {32767, 0}}, 1e7);
    const ImageStats stats =
        image_stats(e, test::skull_volume(), scene, kCanvas, samples_of(w, 20), row);
    note_deviation(std::max(std::abs(stats.smallest - 1), std::abs(stats.largest - 1)), 0,
                   "absolute", row);
  });
  add("all-opaque function", [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
    diaphane::v1::Scene scene = beam({30, 20, 10}, {0, 0, 0}, 10);
    set_medium(scene, {{-32768, 1}, {32767, 1}}, 1e7);
    const ImageStats stats =
        image_stats(e, test::skull_volume(), scene, kCanvas, samples_of(w, 20), row);
    note_deviation(stats.largest, 0, "absolute", row);
  });
  return cases;
}

std::vector<StabilityCase> ray_cases() {
  using Rays = std::vector<std::pair<Double3, Double3>>;
  const auto rays_through = [](const Rays& rays, double width) {
    return [=](Engine& e, const StabilityOptions& w, StabilityRow& row) {
      const volume::Volume v = test::constant_volume(16, 100);
      for (const auto& [from, to] : rays) {
        const double length = length_inside(v.header, from, to);
        diaphane::v1::Scene scene = beam(from, to, width);
        set_medium(scene, {{0, 1}, {200, 1}}, 0.05);
        compare(image_stats(e, v, scene, kCanvas, samples_of(w, 60), row), std::exp(-0.05 * length),
                row);
      }
    };
  };
  Rays axes, inside, negative_zero;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-30.0, 30.0}) {
      axes.emplace_back(along(axis, sign), Double3{0, 0, 0});
      inside.emplace_back(along(axis, sign / 30), along(axis, -sign / 30));
      negative_zero.emplace_back(
          Double3{axis == 0 ? sign : -0.0, axis == 1 ? sign : -0.0, axis == 2 ? sign : -0.0},
          Double3{-0.0, -0.0, -0.0});
    }
  }
  inside.emplace_back(Double3{0.3, 0.2, -0.1}, Double3{5, 4, 7});
  // Rays exactly on voxel borders, cell borders and their intersections.
  Rays borders = {{{0, 0, 30}, {0, 0, 0}}, {{0, 4, 30}, {0, 4, 0}}, {{30, -4, 4}, {0, -4, 4}}};
  const Rays corners = {{{30, 30, 30}, {0, 0, 0}},
                        {{-30, 30, -30}, {0, 0, 0}},
                        {{30, 30, 0}, {0, 0, 0}},
                        {{0, -30, 30}, {0, 0, 0}}};
  return {
      {"rays along every axis", rays_through(axes, 1e-4)},
      {"rays on borders of voxels and cells", rays_through(borders, 1e-6)},
      {"rays from inside", rays_through(inside, 1e-4)},
      {"rays through corners and edges", rays_through(corners, 1e-4)},
      {"coordinates of -0", rays_through(negative_zero, 1e-4)},
      {"rays in the faces of the box", [](Engine& e, const StabilityOptions& w, StabilityRow& row) {
         // Cases of measure zero, in which any finite transmittance is valid.
         const volume::Volume v = test::constant_volume(16, 100);
         for (const Double3 p : {Double3{8, 0, 30}, Double3{8, 8, 30}, Double3{-8, 8, 30}}) {
           diaphane::v1::Scene scene = beam(p, {p.x, p.y, 0}, 1e-9);
           set_medium(scene, {{0, 1}, {200, 1}}, 0.05);
           const ImageStats stats = image_stats(e, v, scene, {8, 8}, samples_of(w, 60), row);
           note_deviation(std::max({stats.largest - 1, -stats.smallest, 0.0}), 0, "absolute", row);
         }
       }}};
}

}  // namespace diaphane::render::bench
