#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_folders.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

// Compares the whole estimator with one that shares only the definition of the scene. That one uses
// double precision, the standard library's generator, one majorant for the volume, no grid, no
// tables, delta tracking also for shadows, and world space throughout. It is slow and plain on
// purpose.

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;

struct V {
  double x, y, z;
};
V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
V operator*(V a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double inner(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
V outer(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
V unit(V a) { return a * (1 / std::sqrt(inner(a, a))); }
V of(const diaphane::v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// Supports scenes of one linear channel, one lamp and one sky, with isotropic scattering, in a
/// volume whose direction matrix is the identity.
class BruteForce {
 public:
  BruteForce(const volume::Volume& volume, const diaphane::v1::Scene& scene, Canvas canvas)
      : volume_(volume), scene_(scene), canvas_(canvas) {
    const auto& h = volume.header;
    half_ = {0.5 * h.size[0] * h.spacing[0], 0.5 * h.size[1] * h.spacing[1],
             0.5 * h.size[2] * h.spacing[2]};
    const auto& f = scene.transfer_function();
    low_ = f.channels(0).opacity(0).value();
    high_ = f.channels(0).opacity(1).value();
    majorant_ = f.extinction_per_mm();
    eye_ = of(scene.camera().eye());
    back_ = unit(eye_ - of(scene.camera().target()));
    right_ = unit(outer(of(scene.camera().up()), back_));
    up_ = outer(back_, right_);
    tangent_ = std::tan(scene.camera().vertical_fov_degrees() * std::numbers::pi / 360);
    for (const auto& light : scene.lights()) {
      if (light.has_environment()) {
        sky_ = light.environment().radiance().r();
      } else {
        corner_ = of(light.rectangle().corner());
        u_ = of(light.rectangle().u());
        v_ = of(light.rectangle().v());
        lamp_ = light.rectangle().radiance().r();
      }
    }
  }

  /// Returns the red component of one sample.
  double sample(double x, double y) {
    const double a =
        (2 * (x + uniform()) / canvas_.width - 1) * tangent_ * canvas_.width / canvas_.height;
    const double b = (1 - 2 * (y + uniform()) / canvas_.height) * tangent_;
    V place = eye_;
    const V d = unit(right_ * a + up_ * b - back_);
    if (!collides(place, d, 1e30)) return sky_;
    const V normal = unit(outer(u_, v_));
    const V to = corner_ + u_ * uniform() + v_ * uniform() - place;
    const double distance = std::sqrt(inner(to, to));
    const double cosine = -inner(normal, to) / distance;
    double light = 0;
    const V area = outer(u_, v_);
    V ghost = place;
    if (cosine > 0 && !collides(ghost, to * (1 / distance), distance)) {
      light += lamp_ * cosine * std::sqrt(inner(area, area)) / (distance * distance) /
               (4 * std::numbers::pi);
    }
    const double z = 2 * uniform() - 1, angle = 2 * std::numbers::pi * uniform();
    const double r = std::sqrt(1 - z * z);
    ghost = place;
    if (!collides(ghost, {r * std::cos(angle), r * std::sin(angle), z}, 1e30)) light += sky_;
    return light * scene_.transfer_function().channels(0).diffuse().r();
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(generator_); }

  /// Moves `place` to the first collision within `most` mm. Returns whether there is one.
  bool collides(V& place, V d, double most) {
    double begin = 0, end = most;
    const double o[] = {place.x, place.y, place.z}, w[] = {d.x, d.y, d.z},
                 h[] = {half_.x, half_.y, half_.z};
    for (int axis = 0; axis < 3; ++axis) {
      const double p = (-h[axis] - o[axis]) / w[axis], q = (h[axis] - o[axis]) / w[axis];
      begin = std::max(begin, std::min(p, q));
      end = std::min(end, std::max(p, q));
    }
    for (double t = begin;;) {
      t -= std::log(1 - uniform()) / majorant_;
      if (!(t < end)) return false;
      const V p = place + d * t;
      if (uniform() * majorant_ < extinction(p)) {
        place = p;
        return true;
      }
    }
  }

  double extinction(V p) const {
    const auto& h = volume_.header;
    const double q[] = {(p.x + half_.x) / h.spacing[0] - 0.5, (p.y + half_.y) / h.spacing[1] - 0.5,
                        (p.z + half_.z) / h.spacing[2] - 0.5};
    double value = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::size_t index[3];
      for (int axis = 0; axis < 3; ++axis) {
        const double floor = std::floor(q[axis]), w = q[axis] - floor;
        const int up = corner >> axis & 1;
        weight *= up != 0 ? w : 1 - w;
        const double last = h.size[static_cast<std::size_t>(axis)] - 1.0;
        index[axis] = static_cast<std::size_t>(std::clamp(floor + up, 0.0, last));
      }
      value += weight * volume_.voxels[index[0] + h.size[0] * (index[1] + h.size[1] * index[2])];
    }
    return shown(q) * majorant_ * std::clamp((value - low_) / (high_ - low_), 0.0, 1.0);
  }

  /// Returns the opacity of the label of the voxel whose centre is nearest to `q`, in indices of
  /// centres.
  double shown(const double* q) const {
    const auto& set = volume_.label_set;
    if (set.empty()) return 1;
    std::size_t index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double last = volume_.header.size[static_cast<std::size_t>(axis)] - 1.0;
      index[axis] = static_cast<std::size_t>(std::clamp(std::floor(q[axis] + 0.5), 0.0, last));
    }
    const auto& h = volume_.header;
    const std::uint8_t label =
        set.labels.voxels[index[0] + h.size[0] * (index[1] + h.size[1] * index[2])];
    for (const auto& look : scene_.labels()) {
      if (label > 0 && look.number() == set.table[label - 1].number) return look.opacity();
    }
    return 1;
  }

  const volume::Volume& volume_;
  const diaphane::v1::Scene& scene_;
  Canvas canvas_;
  V half_{}, eye_{}, back_{}, right_{}, up_{}, corner_{}, u_{}, v_{};
  double low_ = 0, high_ = 0, majorant_ = 0, tangent_ = 0, sky_ = 0, lamp_ = 0;
  std::mt19937_64 generator_{12345};
};

/// For each square tile of `kTile` pixels, each of `rounds` independent small pictures gives one
/// mean. Welch's t compares the two renderers, with Sidak's correction over the tiles. The means of
/// the whole picture are compared too.
void expect_agreement(const volume::Volume& volume, const diaphane::v1::Scene& scene, Canvas canvas,
                      std::uint32_t samples) {
  constexpr std::uint32_t kTile = 8;
  const std::uint32_t tiles_x = canvas.width / kTile, tiles_y = canvas.height / kTile;
  std::vector<test::Moments> ours(tiles_x * tiles_y), theirs(tiles_x * tiles_y);
  test::Moments our_mean, their_mean;
  const auto engine = make_cpu_engine(0);
  const auto loaded = engine->load(volume).value();
  BruteForce brute(volume, scene, canvas);
  for (std::uint32_t s = 0; s < samples; ++s) {
    const auto renderer = engine->renderer(loaded, 1, s).value();
    ASSERT_TRUE(renderer->set_scene(scene, canvas));
    ASSERT_TRUE(renderer->render(1, nullptr));
    PictureRgbF picture;
    ASSERT_TRUE(renderer->radiance(picture));
    double our_sum = 0, their_sum = 0;
    for (std::uint32_t y = 0; y < canvas.height; ++y) {
      for (std::uint32_t x = 0; x < canvas.width; ++x) {
        const std::size_t tile = x / kTile + tiles_x * (y / kTile);
        const double our = picture.pixels[3 * (x + std::size_t{canvas.width} * y)];
        const double their = brute.sample(x, y);
        ours[tile].add(our);
        theirs[tile].add(their);
        our_sum += our;
        their_sum += their;
      }
    }
    our_mean.add(our_sum);
    their_mean.add(their_sum);
  }
  const double limit = test::critical_z(test::sidak(kAlpha, ours.size() + 1));
  for (std::size_t tile = 0; tile < ours.size(); ++tile) {
    // The pixels of a tile differ, so the samples of a tile are strata. The variance over all of
    // them is larger than that of their mean, so the test is conservative.
    EXPECT_LT(std::abs(test::welch(ours[tile], theirs[tile])), limit)
        << "tile " << tile << ": " << ours[tile].mean << " against " << theirs[tile].mean;
  }
  EXPECT_LT(std::abs(test::welch(our_mean, their_mean)), limit);
  EXPECT_NEAR(our_mean.mean / their_mean.mean, 1, 0.01);
}

TEST(BruteForce, AgreesOnEveryTileOfTheSkull) {
  expect_agreement(test::skull_volume(), test::skull_scene(), {64, 64}, 64);
}

TEST(BruteForce, AgreesOnEveryTileOfThinAndThickMedia) {
  for (const double extinction : {0.02, 10.0}) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
    expect_agreement(test::skull_volume(), scene, {32, 32}, 48);
  }
}

TEST(BruteForce, AgreesOnEveryTileWithLabels) {
  volume::Volume volume = test::skull_volume();
  test::mark(volume, [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return x < 20 ? 1 : (x + y + z) % 7 < 3 ? 2 : z > 18 ? 3 : 0;
  });
  for (const double extinction : {0.8, 10.0}) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
    const double opacities[] = {0.05, 0.5, 0};
    for (std::uint32_t i = 0; i < 3; ++i) {
      auto* look = scene.add_labels();
      look->set_number(10 * (i + 1));
      look->set_opacity(opacities[i]);
    }
    expect_agreement(volume, scene, {32, 32}, 48);
  }
}

/// Renders the scene of tests/scenes/cranium.json on the CT for which it was made, if that is
/// installed.
TEST(BruteForce, AgreesOnEveryTileOfTheCranium) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> tar(
      popen("tar -xzOf /usr/share/doc/invesalius-examples/examples/Cranium.inv3 --wildcards "
            "'*/matrix.dat' 2>/dev/null",
            "r"),
      &pclose);
  volume::Volume volume;
  volume.header.size = {256, 256, 108};
  volume.header.spacing = {0.957, 0.957, 1.5};
  volume.voxels.resize(volume.header.voxel_count());
  if (tar == nullptr || std::fread(volume.voxels.data(), 2, volume.voxels.size(), tar.get()) !=
                            volume.voxels.size()) {
    GTEST_SKIP() << "the package invesalius-examples is not installed";
  }
  for (std::int16_t& v : volume.voxels) {
    v = static_cast<std::int16_t>(std::lround(30000 * std::clamp((v - 150) / 450.0, 0.0, 1.0)));
  }
  volume::measure(volume);
  std::string json;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      std::fopen((std::string(test::kScenes) + "/cranium.json").c_str(), "r"), &std::fclose);
  ASSERT_NE(file, nullptr);
  for (int c = std::fgetc(file.get()); c != EOF; c = std::fgetc(file.get()))
    json.push_back(static_cast<char>(c));
  const auto scene = scene_from_json(json);
  ASSERT_TRUE(scene) << scene.error().message;
  expect_agreement(volume, *scene, {64, 64}, 24);
}

}  // namespace
}  // namespace diaphane::render
