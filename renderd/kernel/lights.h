#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/light_texture.h"
#include "renderd/kernel/views.h"
#include "renderd/math/disk.h"
#include "renderd/math/vector.h"

// Lights of finite size, as seen from a place in mm in the volume's frame: sampling a point on one,
// and intersecting a ray with one. Densities are per steradian and for the light alone, without the
// probability of choosing it.

namespace diaphane::render {

/// Density of a direction that only one technique can sample.
inline constexpr float kDeltaDensity = 3.4e38f;

/// Light from one sampled point, before transmittance and scattering.
struct LightSample {
  Float3 direction;   ///< unit, from the lit place to the light
  float distance;     ///< mm
  Float3 irradiance;  ///< radiance over the density and the light's probability
  float density;      ///< density of sample_light() in this direction; kDeltaDensity for a point
  bool lit;           ///< false: no light of this point reaches the place
};

/// The intersection of a ray with a light.
struct LightHit {
  Float3 radiance;
  float distance;  ///< mm
  float density;   ///< density of sample_light() in this direction
  bool met;
};

/// Samples the index of a light with `u` in (0, 1), and rescales `u` to (0, 1) so that it can be
/// used again. Uses bisection, because there may be thousands of lights.
HOST_DEVICE std::uint32_t pick_light(const LightsView& lights, float& u) {
  const std::uint32_t i = first_above(
      lights.count, u, [&lights](std::uint32_t k) { return lights.area[k].cumulative; });
  u = stretched(u, lights.area[i].probability, lights.area[i].cumulative);
  return i;
}

/// Returns the point of a projected texture that the unit direction `away` leads to from `point`, a
/// point of the light relative to its middle.
HOST_DEVICE TexturePoint projected_point(const AreaLight& light, Float3 point, Float3 away) {
  const Float3 right = light.u * (1.0f / sqrtf(dot(light.u, light.u)));
  const Float3 there = point + away * (light.focus / dot(away, light.normal));
  return {0.5f + dot(there, right) * light.per_mm,
          0.5f + dot(there, cross(light.normal, right)) * light.per_mm};
}

/// Returns the light's radiance at the point `p` of its texture.
template <Features F, TextureEdge Edge = TextureEdge::kClamp>
HOST_DEVICE Float3 radiance_at(const LightsView& lights, const AreaLight& light, TexturePoint p) {
  if constexpr (F.has(Feature::kTexturedLights)) {
    if (light.texture != kNoTexture) {
      return light.radiance * colour_at<Edge>(lights, lights.textures[light.texture], p);
    }
  }
  (void)lights;
  (void)p;
  return light.radiance;
}

/// Returns the radiance of a rectangle or disk along the unit direction `away` from a point of it:
/// `q` relative to its corner or centre, and `p` in its texture.
template <Features F>
HOST_DEVICE Float3 flat_radiance(const LightsView& lights, const AreaLight& light, Float3 q,
                                 TexturePoint p, Float3 away) {
  if constexpr (F.has(Feature::kTexturedLights)) {
    if (light.per_mm > 0.0f) {
      const bool disk = light.shape == LightShape::kDisk;
      p = projected_point(light, disk ? q : q - (light.u + light.v) * 0.5f, away);
      const bool inside = p.across >= 0.0f && p.across <= 1.0f && p.down >= 0.0f && p.down <= 1.0f;
      if (!inside) return Float3{0.0f, 0.0f, 0.0f};
    }
  }
  (void)q;
  (void)away;
  return radiance_at<F>(lights, light, p);
}

/// Returns the radiance of a sphere at the end of the radius `r` from its centre; rr is the squared
/// radius.
template <Features F>
HOST_DEVICE Float3 sphere_radiance(const LightsView& lights, const AreaLight& light, Float3 r,
                                   float rr) {
  TexturePoint p{0.0f, 0.0f};
  if constexpr (F.has(Feature::kTexturedLights)) {
    if (rr > 0.0f) {
      // u and v have the length of a radius, but the pole is a unit vector.
      p = map_point(dot(r, light.u), dot(r, light.v), dot(r, light.normal) * sqrtf(rr));
    }
  }
  return radiance_at<F, TextureEdge::kWrapAcross>(lights, light, p);
}

/// The cone in which a sphere is visible from a place.
struct SphereCone {
  Float3 axis;          ///< unit, to the centre
  float distance2, rr;  ///< squares of the distance to the centre and of the radius, mm^2
  /// 1 - cos of half the opening angle, without cancellation for a small or distant sphere.
  float one_minus_cos;
  float solid_angle;  ///< steradians; for a point, its area (1 mm^2) over the squared distance
  bool outside;
};
HOST_DEVICE SphereCone sphere_cone(const AreaLight& light, Float3 place) {
  SphereCone cone{};
  const Float3 to = light.corner - place;
  cone.distance2 = dot(to, to);
  cone.rr = dot(light.u, light.u);
  cone.outside = cone.distance2 > cone.rr;
  if (!cone.outside) return cone;
  cone.axis = to * (1.0f / sqrtf(cone.distance2));
  const float cosine = sqrtf((cone.distance2 - cone.rr) / cone.distance2);
  cone.one_minus_cos = cone.rr / cone.distance2 / (1.0f + cosine);
  cone.solid_angle = light.area / cone.distance2 * (2.0f / (1.0f + cosine));
  return cone;
}

/// Samples a direction uniformly over the cone in which a place outside sees the sphere. Returns no
/// light for a place inside.
template <Features F>
HOST_DEVICE LightSample sample_sphere_light(const LightsView& lights, const AreaLight& light,
                                            Float3 place, float u, float v) {
  LightSample s{};
  const SphereCone cone = sphere_cone(light, place);
  if (!cone.outside) return s;
  const float c = u * cone.one_minus_cos;
  const float sine2 = c * (2.0f - c);
  Float3 x, y;
  basis_around(cone.axis, x, y);
  const float turn = 2.0f * kPi * v, sine = sqrtf(sine2);
  s.direction = x * (sine * cosf(turn)) + y * (sine * sinf(turn)) + cone.axis * (1.0f - c);
  const float half_chord = sqrtf(max(cone.rr - cone.distance2 * sine2, 0.0f));
  s.distance = sqrtf(cone.distance2) * (1.0f - c) - half_chord;
  const Float3 radius = place + s.direction * s.distance - light.corner;
  s.irradiance =
      sphere_radiance<F>(lights, light, radius, cone.rr) * (cone.solid_angle / light.probability);
  s.density = cone.rr > 0.0f ? 1.0f / cone.solid_angle : kDeltaDensity;
  s.lit = true;
  return s;
}

/// Samples a point uniformly over the light's area, or for a sphere a direction uniformly over its
/// solid angle.
template <Features F>
HOST_DEVICE LightSample sample_light(const LightsView& lights, const AreaLight& light, Float3 place,
                                     float u, float v) {
  LightSample s{};
  TexturePoint p{u, v};
  if constexpr (F.has(Feature::kShapedLights)) {
    if (light.shape == LightShape::kSphere) {
      return sample_sphere_light<F>(lights, light, place, u, v);
    }
    if (light.shape == LightShape::kDisk) {
      const DiskPoint d = sample_disk(u, v);
      u = d.x;
      v = d.y;
      p = {0.5f + 0.5f * d.x, 0.5f - 0.5f * d.y};
    }
  }
  const Float3 q = light.u * u + light.v * v;
  const Float3 to = light.corner + q - place;
  const float squared = dot(to, to);
  const float facing = -dot(light.normal, to);  // cosine times distance
  if (!(facing > 0.0f) || !(squared > 0.0f)) return s;
  const float distance = sqrtf(squared);
  s.direction = to * (1.0f / distance);
  s.distance = distance;
  const float solid_angle = facing / distance / squared * light.area;
  s.irradiance = flat_radiance<F>(lights, light, q, p, s.direction * -1.0f) *
                 (solid_angle / light.probability);
  s.density = 1.0f / solid_angle;
  if constexpr (F.has(Feature::kShapedLights)) {
    if (light.shape == LightShape::kDisk && !(dot(light.u, light.u) > 0.0f)) {
      s.density = kDeltaDensity;
    }
  }
  s.lit = true;
  return s;
}

template <Features F>
HOST_DEVICE LightHit meet_sphere_light(const LightsView& lights, const AreaLight& light,
                                       Float3 place, Float3 direction) {
  LightHit hit{};
  const SphereCone cone = sphere_cone(light, place);
  if (!cone.outside) return hit;
  const Float3 to = light.corner - place;
  const float along = dot(to, direction);
  const Float3 across = to - direction * along;
  const float off2 = dot(across, across);
  if (!(along > 0.0f) || !(off2 < cone.rr)) return hit;
  hit.distance = max(along - sqrtf(cone.rr - off2), 0.0f);
  const Float3 radius = direction * hit.distance - to;
  hit.radiance = sphere_radiance<F>(lights, light, radius, cone.rr);
  hit.density = 1.0f / cone.solid_angle;
  hit.met = true;
  return hit;
}

/// Returns where the ray from `place` along the unit `direction` meets the shining side of the
/// light.
template <Features F>
HOST_DEVICE LightHit meet_light(const LightsView& lights, const AreaLight& light, Float3 place,
                                Float3 direction) {
  if constexpr (F.has(Feature::kShapedLights)) {
    if (light.shape == LightShape::kSphere) {
      return meet_sphere_light<F>(lights, light, place, direction);
    }
  }
  LightHit hit{};
  const float cosine = -dot(light.normal, direction);
  const float height = -dot(light.normal, light.corner - place);
  if (!(cosine > 0.0f) || !(height > 0.0f)) return hit;
  hit.distance = height / cosine;
  const Float3 q = place + direction * hit.distance - light.corner;
  TexturePoint p{};
  bool inside = false;
  if (F.has(Feature::kShapedLights) && light.shape == LightShape::kDisk) {
    const float rr = dot(light.u, light.u);
    inside = dot(q, q) < rr;
    p = {0.5f + 0.5f * dot(q, light.u) / rr, 0.5f - 0.5f * dot(q, light.v) / rr};
  } else {
    const float inverse = 1.0f / light.area;
    p = {dot(cross(q, light.v), light.normal) * inverse,
         dot(cross(light.u, q), light.normal) * inverse};
    inside = p.across >= 0.0f && p.across <= 1.0f && p.down >= 0.0f && p.down <= 1.0f;
  }
  if (!inside) return hit;
  hit.radiance = flat_radiance<F>(lights, light, q, p, direction * -1.0f);
  hit.density = hit.distance * hit.distance / (cosine * light.area);
  hit.met = true;
  return hit;
}

}  // namespace diaphane::render
