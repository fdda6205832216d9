#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <utility>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/math/random.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/prepared_scene.h"
#include "volume/volume.h"

// Volumes and scenes shared by the tests of the renderer.

namespace diaphane::render::test {

inline void set(diaphane::v1::Vec3* to, double x, double y, double z) {
  to->set_x(x);
  to->set_y(y);
  to->set_z(z);
}
inline void set(diaphane::v1::Rgb* to, double r, double g, double b) {
  to->set_r(r);
  to->set_g(g);
  to->set_b(b);
}

inline diaphane::v1::Channel* add_channel(diaphane::v1::TransferFunction& function,
                                          std::initializer_list<std::pair<double, double>> points,
                                          double r = 0.8, double g = 0.8, double b = 0.8) {
  auto* channel = function.add_channels();
  for (const auto& [value, opacity] : points) {
    auto* point = channel->add_opacity();
    point->set_value(value);
    point->set_opacity(opacity);
  }
  set(channel->mutable_diffuse(), r, g, b);
  return channel;
}

/// Adds a square of edge `side` that shines down -z, centred above the origin.
inline void add_lamp(diaphane::v1::Scene& scene, double x, double y, double z, double side,
                     double radiance) {
  auto* light = scene.add_lights()->mutable_rectangle();
  set(light->mutable_corner(), x - side / 2, y - side / 2, z);
  set(light->mutable_u(), 0, side, 0);
  set(light->mutable_v(), side, 0, 0);
  set(light->mutable_radiance(), radiance, radiance, radiance);
}
inline void add_sky(diaphane::v1::Scene& scene, double radiance) {
  set(scene.add_lights()->mutable_environment()->mutable_radiance(), radiance, radiance, radiance);
}
inline void set_camera(diaphane::v1::Scene& scene, double x, double y, double z, double fov) {
  set(scene.mutable_camera()->mutable_eye(), x, y, z);
  set(scene.mutable_camera()->mutable_target(), 0, 0, 0);
  set(scene.mutable_camera()->mutable_up(), 0, 0, 1);
  scene.mutable_camera()->set_vertical_fov_degrees(fov);
}

/// Makes a volume with `value(x, y, z)` at the voxel centres, where x, y, z are voxel indices +
/// 1/2.
inline volume::Volume make_volume(std::array<std::uint32_t, 3> size, std::array<double, 3> spacing,
                                  const std::function<double(double, double, double)>& value) {
  volume::Volume v;
  v.header.size = size;
  v.header.spacing = spacing;
  v.voxels.reserve(v.header.voxel_count());
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x) {
        v.voxels.push_back(
            static_cast<std::int16_t>(std::lround(value(x + 0.5, y + 0.5, z + 0.5))));
      }
    }
  }
  volume::measure(v);
  return v;
}

inline volume::Volume constant_volume(std::uint32_t n, double value, double spacing = 1) {
  return make_volume({n, n, n}, {spacing, spacing, spacing},
                     [value](double, double, double) { return value; });
}

/// A volume like the head of tests/scenes: a bony shell with holes and a few solid lumps in it,
/// values 0 to 30000, anisotropic voxels.
inline volume::Volume skull_volume() {
  return make_volume({48, 48, 30}, {1, 1, 1.6}, [](double x, double y, double z) {
    const double a = (x - 24) / 20, b = (y - 24) / 22, c = (z - 15) / 13;
    const double r = std::sqrt(a * a + b * b + c * c);
    const double shell = 1 - std::abs(r - 0.85) / 0.12;
    const double hole = std::hypot(a - 0.35, c - 0.1) < 0.22 && b > 0 ? 1 : 0;
    const double lump = 1 - std::hypot(a + 0.3, b - 0.1, c) / 0.3;
    const double teeth = r < 0.8 && std::sin(1.3 * x) * std::sin(1.1 * y) > 0.6 ? 0.5 : 0;
    const double v = std::max({shell * (1 - hole), lump, teeth * (c < -0.3 ? 1 : 0)});
    return 30000 * std::min(std::max(v * 1.8, 0.0), 1.0);
  });
}

/// Gives the voxels of a volume the labels `label(x, y, z)` of their indices. Label i has the
/// number 10 i.
inline void mark(volume::Volume& volume,
                 const std::function<int(std::uint32_t, std::uint32_t, std::uint32_t)>& label) {
  const auto& size = volume.header.size;
  volume::LabelSet set;
  set.labels.size = size;
  std::uint32_t most = 0;
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x) {
        const auto own = static_cast<std::uint8_t>(label(x, y, z));
        most = std::max<std::uint32_t>(most, own);
        set.labels.voxels.push_back(own);
      }
    }
  }
  for (std::uint32_t i = 1; i <= most; ++i) set.table.push_back({10 * i, {}, {}});
  volume.label_set = std::move(set);
}

/// A scene with the material and lights of the cranium scene, for skull_volume().
inline diaphane::v1::Scene skull_scene() {
  diaphane::v1::Scene scene;
  add_channel(*scene.mutable_transfer_function(), {{0, 0}, {30000, 1}}, 0.9, 0.85, 0.75);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.8);
  add_lamp(scene, -20, 15, 70, 40, 30);
  add_sky(scene, 0.5);
  set_camera(scene, 45, 80, 28, 36);
  scene.mutable_display()->set_show_environment(true);
  return scene;
}

/// A prepared volume and scene, with views for calling the kernel directly.
class Prepared {
 public:
  Prepared(volume::Volume volume, const diaphane::v1::Scene& scene, Canvas canvas = {16, 16})
      : volume_(std::move(volume)),
        grid_(grid_of(volume_)),
        scene_(prepare_scene(scene, canvas, volume_.header, grid_).value()) {}
  /// With a second scan. `to_first` maps its points to those of the first.
  Prepared(volume::Volume volume, volume::Volume second, const volume::Matrix& to_first,
           const diaphane::v1::Scene& scene, Canvas canvas = {16, 16})
      : volume_(std::move(volume)),
        second_(std::move(second)),
        grid_(grid_of(volume_)),
        second_grid_(grid_of(second_)),
        scene_(with_second(to_first, scene, canvas)) {}

  const PreparedScene& scene() const { return scene_; }
  const ValueGrid& grid() const { return grid_; }
  const volume::Volume& volume() const { return volume_; }
  SceneView<LinearVolume> view(std::uint64_t seed = 1) const {
    const PreparedTransfer& t = *scene_.transfer;
    SceneView<LinearVolume> view = view_of(
        scene_, LinearVolume{volume_.voxels.data(), size_of(volume_.header)}, t.extinction.data(),
        t.colour.data(), bounds_of(scene_).data(), LightArrays(scene_), seed);
    if (!t.gloss.empty()) view.transfer.gloss = t.gloss.data();
    if (!t.emission.empty()) view.transfer.emission = t.emission.data();
    if (scene_.labels) {
      view.labels = {volume_.label_set.labels.voxels.data(), scene_.labels->looks.data()};
    }
    if (scene_.overlay) {
      const PreparedTransfer& o = *scene_.overlay->transfer;
      const auto table = [](const std::vector<Float4>& values) {
        return values.empty() ? nullptr : values.data();
      };
      add_overlay(scene_, LinearVolume{second_.voxels.data(), size_of(second_.header)},
                  {o.extinction.data(), o.colour.data(), table(o.gloss), table(o.emission),
                   scene_.overlay->majorants.data()},
                  view);
    }
    view.exact = exact_view_of(scene_, grid_, size_of(volume_.header), t.exact.pieces.data(),
                               t.exact.piece_of.data(), t.exact.skips.data());
    return view;
  }

 private:
  static ValueGrid grid_of(const volume::Volume& volume) {
    ValueGrid grid = make_value_grid(volume.voxels, size_of(volume.header));
    grid.labels = make_label_grid(volume.label_set, size_of(volume.header));
    return grid;
  }

  PreparedScene with_second(const volume::Matrix& to_first, const diaphane::v1::Scene& scene,
                            Canvas canvas) const {
    const SecondScan second{second_.header, second_grid_, to_first};
    return prepare_scene(scene, canvas, volume_.header, grid_, nullptr, nullptr, nullptr, &second)
        .value();
  }

  volume::Volume volume_, second_;  ///< the second may be empty
  ValueGrid grid_, second_grid_;
  PreparedScene scene_;
};

}  // namespace diaphane::render::test
