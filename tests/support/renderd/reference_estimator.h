#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/film/canvas.h"
#include "volume/volume.h"

// For tests: estimates scattering directly from the definition of a scene, in double precision and
// world space. It uses the simplest methods: one majorant for the whole volume, no grid, no tables,
// shadows by delta tracking, a rectangle picked with uniform probability, uniform directions over
// the whole sphere for the sky and for the next ray, and no roulette. It shares no code with the
// renderer.

namespace diaphane::render::test {

struct Triple {
  std::array<double, 3> of;

  double operator[](std::size_t axis) const { return of[axis]; }
  double& operator[](std::size_t axis) { return of[axis]; }
};

inline Triple operator+(Triple a, Triple b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Triple operator-(Triple a, Triple b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Triple operator*(Triple a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double inner(Triple a, Triple b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Triple outer(Triple a, Triple b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Triple unit(Triple a) { return a * (1 / std::sqrt(inner(a, a))); }
inline Triple triple(const diaphane::v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Triple triple(const diaphane::v1::Rgb& c) { return {c.r(), c.g(), c.b()}; }

class ReferenceEstimator {
 public:
  ReferenceEstimator(const volume::Volume& volume, const diaphane::v1::Scene& scene, Canvas canvas,
                     std::uint64_t seed)
      : volume_(volume), scene_(scene), canvas_(canvas), generator_(seed) {
    const auto& camera = scene.camera();
    back_ = unit(triple(camera.eye()) - triple(camera.target()));
    right_ = unit(outer(triple(camera.up()), back_));
    up_ = outer(back_, right_);
    for (const auto& light : scene.lights()) {
      if (light.has_environment()) {
        sky_ = sky_ + triple(light.environment().radiance());
        continue;
      }
      const auto& r = light.rectangle();
      Rectangle out{triple(r.corner()), triple(r.u()), triple(r.v()), triple(r.radiance())};
      if (light.camera_locked()) {
        out.corner = triple(camera.target()) + from_camera(out.corner);
        out.u = from_camera(out.u);
        out.v = from_camera(out.v);
      }
      rectangles_.push_back(out);
    }
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      const auto& d = volume.header.direction;
      axes_[axis] = {d[axis], d[3 + axis], d[6 + axis]};
      half_[axis] = 0.5 * volume.header.size[axis] * volume.header.spacing[axis];
    }
  }

  /// Returns one estimate of the radiance through pixel (x, y).
  Triple sample(std::uint32_t x, std::uint32_t y) {
    const double tangent =
        std::tan(scene_.camera().vertical_fov_degrees() * std::numbers::pi / 360);
    const double a = (2 * (x + uniform()) / canvas_.width - 1) * tangent * canvas_.width /
                     static_cast<double>(canvas_.height);
    const double b = (1 - 2 * (y + uniform()) / canvas_.height) * tangent;
    Triple ray = unit(right_ * a + up_ * b - back_);
    Triple place = triple(scene_.camera().eye());
    double value = 0;
    if (!collides(place, ray, 1e30, value)) {
      return scene_.display().show_environment() ? sky_ : triple(scene_.display().background());
    }
    Triple radiance{}, weight{1, 1, 1};
    const auto times = [](Triple p, Triple q) {
      return Triple{p[0] * q[0], p[1] * q[1], p[2] * q[2]};
    };
    for (std::uint32_t collisions = 1;; ++collisions) {
      const Matter matter = matter_at(place, value, ray);
      const Triple light = from_rectangles(place, matter) + from_sky(place, matter);
      radiance = radiance + times(weight, matter.emission + times(matter.albedo, light));
      if (collisions >= scene_.bounces()) return radiance;
      ray = anywhere();
      weight = times(weight, matter.albedo) * (4 * std::numbers::pi * scattered(matter, ray));
      if (!collides(place, ray, 1e30, value)) return radiance;
    }
  }

 private:
  struct Rectangle {
    Triple corner, u, v, radiance;
  };

  double uniform() { return std::uniform_real_distribution<double>(0, 1)(generator_); }
  Triple from_camera(Triple v) const { return right_ * v[0] + up_ * v[1] + back_ * v[2]; }

  struct Matter {
    Triple incoming, albedo, emission;
    bool surface;
    Triple normal;
  };

  Triple anywhere() {
    const double z = 2 * uniform() - 1, angle = 2 * std::numbers::pi * uniform();
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

  /// Returns the phase function, or Lambert's BRDF times the cosine.
  double scattered(const Matter& matter, Triple towards) const {
    if (!matter.surface) return phase(inner(matter.incoming, towards));
    return std::max(inner(matter.normal, towards), 0.0) / std::numbers::pi;
  }

  Matter matter_at(Triple place, double value, Triple ray) {
    const diaphane::v1::LabelLook look = look_at(place);
    Matter matter{ray,
                  look.has_colour()
                      ? triple(look.colour())
                      : mean_of(value, [](const auto& c) { return triple(c.diffuse()); }),
                  mean_of(value, [](const auto& c) { return triple(c.emission()); }),
                  false,
                  {}};
    matter.albedo = tinted(place, matter.albedo);
    const auto mode = scene_.shading().mode();
    if (mode == diaphane::v1::Shading::PHASE) return matter;
    const auto& spacing = volume_.header.spacing;
    Triple gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Triple step = axes_[axis] * spacing[axis];
      gradient = gradient + axes_[axis] * ((value_at(place + step) - value_at(place - step)) /
                                           (2 * spacing[axis]));
    }
    const double steepness = std::sqrt(inner(gradient, gradient));
    const double least = std::min({spacing[0], spacing[1], spacing[2]});
    const double slope =
        std::abs(opacity_of(value + least * steepness) - opacity_of(value - least * steepness)) /
        (2 * least);
    if (!(slope > 0)) return matter;
    const double shown = slope * shown_of(look);
    matter.surface = mode == diaphane::v1::Shading::SURFACE ||
                     uniform() < 1 - std::exp(-shown / scene_.shading().gradient_scale());
    matter.normal = gradient * ((inner(gradient, ray) > 0 ? -1 : 1) / steepness);
    return matter;
  }

  double phase(double cosine) const {
    const double g = scene_.phase().g();
    const double d = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * std::numbers::pi * d * std::sqrt(d));
  }

  Triple from_rectangles(Triple place, const Matter& matter) {
    if (rectangles_.empty()) return {};
    const auto count = static_cast<double>(rectangles_.size());
    const Rectangle& r = rectangles_[static_cast<std::size_t>(uniform() * count)];
    const Triple to = r.corner + r.u * uniform() + r.v * uniform() - place;
    const double distance = std::sqrt(inner(to, to));
    const Triple towards = to * (1 / distance), area = outer(r.u, r.v);
    // The projected area as seen from `place`.
    const double facing = -inner(area, towards);
    double value = 0;
    if (facing <= 0 || collides(place, towards, distance, value)) return {};
    return r.radiance * (count * scattered(matter, towards) * facing / (distance * distance));
  }

  Triple from_sky(Triple place, const Matter& matter) {
    const Triple towards = anywhere();
    double value = 0;
    if (collides(place, towards, 1e30, value)) return {};
    return sky_ * (4 * std::numbers::pi * scattered(matter, towards));
  }

  /// Moves `place` to the first collision within `most` mm and sets `value` to the value of the
  /// voxels there. Returns whether there is one.
  bool collides(Triple& place, Triple direction, double most, double& value) {
    double begin = 0, end = most;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double o = inner(place, axes_[axis]), d = inner(direction, axes_[axis]);
      const double p = (-half_[axis] - o) / d, q = (half_[axis] - o) / d;
      begin = std::max(begin, std::min(p, q));
      end = std::min(end, std::max(p, q));
    }
    const double majorant = scene_.transfer_function().extinction_per_mm();
    for (double t = begin;;) {
      t -= std::log(1 - uniform()) / majorant;
      if (!(t < end)) return false;
      const Triple p = place + direction * t;
      value = value_at(p);
      if (uniform() < opacity_of(value) * shown_of(look_at(p))) {
        place = p;
        return true;
      }
    }
  }

  double value_at(Triple p) const {
    const auto& h = volume_.header;
    double value = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<std::size_t, 3> index{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double q = (inner(p, axes_[axis]) + half_[axis]) / h.spacing[axis] - 0.5;
        const double low = std::floor(q);
        const bool upper = (corner >> axis & 1) != 0;
        weight *= upper ? q - low : 1 - (q - low);
        index[axis] =
            static_cast<std::size_t>(std::clamp(low + (upper ? 1 : 0), 0.0, h.size[axis] - 1.0));
      }
      value += weight * volume_.voxels[index[0] + h.size[0] * (index[1] + h.size[1] * index[2])];
    }
    return value;
  }

  /// Returns an albedo as the highlight tints it at a place.
  Triple tinted(Triple place, Triple albedo) const {
    const auto& highlight = scene_.highlight();
    const Triple from_centre = place - triple(highlight.centre());
    const bool inside = std::sqrt(inner(from_centre, from_centre)) <= highlight.radius();
    if (!scene_.has_highlight() || !inside) return albedo;
    const double share = highlight.strength() > 0 ? highlight.strength() : 0.75;
    return albedo * (1 - share) + triple(highlight.colour()) * share;
  }

  /// Returns the look of the label of the voxel that contains a place.
  diaphane::v1::LabelLook look_at(Triple p) const {
    const auto& set = volume_.label_set;
    diaphane::v1::LabelLook none;
    if (set.empty()) return none;
    const auto& h = volume_.header;
    std::size_t index = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      const double q = std::floor((inner(p, axes_[axis]) + half_[axis]) / h.spacing[axis]);
      index =
          index * h.size[axis] + static_cast<std::size_t>(std::clamp(q, 0.0, h.size[axis] - 1.0));
    }
    const std::uint8_t label = set.labels.voxels[index];
    const std::uint32_t number = label == 0 ? 0 : set.table[label - 1].number;
    bool alone = false;
    diaphane::v1::LabelLook found;
    for (const auto& look : scene_.labels()) {
      alone = alone || look.solo();
      if (look.number() == number) found = look;
    }
    if (alone && !found.solo()) found.set_opacity(0);
    return found;
  }
  static double shown_of(const diaphane::v1::LabelLook& look) {
    return look.has_opacity() ? look.opacity() : 1;
  }

  static double opacity_of(const diaphane::v1::Channel& channel, double value) {
    if (channel.disabled()) return 0;
    for (int i = 1; i < channel.opacity_size(); ++i) {
      const auto& a = channel.opacity(i - 1);
      const auto& b = channel.opacity(i);
      if (value >= a.value() && value <= b.value()) {
        return a.opacity() +
               (b.opacity() - a.opacity()) * (value - a.value()) / (b.value() - a.value());
      }
    }
    return 0;
  }
  double opacity_of(double value) const {
    double most = 0;
    for (const auto& channel : scene_.transfer_function().channels()) {
      most = std::max(most, opacity_of(channel, value));
    }
    return most;
  }
  /// Returns the mean of a colour of the channels, weighted by their opacities.
  template <typename Colour>
  Triple mean_of(double value, const Colour& colour) const {
    Triple sum{};
    double weight = 0;
    for (const auto& channel : scene_.transfer_function().channels()) {
      const double opacity = opacity_of(channel, value);
      sum = sum + colour(channel) * opacity;
      weight += opacity;
    }
    return weight > 0 ? sum * (1 / weight) : sum;
  }

  const volume::Volume& volume_;
  const diaphane::v1::Scene& scene_;
  Canvas canvas_;
  std::mt19937_64 generator_;
  Triple back_{}, right_{}, up_{}, sky_{};
  std::vector<Rectangle> rectangles_;
  std::array<Triple, 3> axes_{};
  Triple half_{};
};

}  // namespace diaphane::render::test
