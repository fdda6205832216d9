#pragma once

#include "renderd/kernel/lights.h"

// Lights as a kernel sees them, made without a scene and shared by tests of lights. Each is the
// only light, so it is always chosen.

namespace diaphane::render::test {

inline AreaLight rectangle(Float3 corner, Float3 u, Float3 v, Float3 radiance = {2, 3, 5}) {
  AreaLight light{};
  light.corner = corner;
  light.u = u;
  light.v = v;
  light.normal = normalize(cross(u, v));
  light.area = length(cross(u, v));
  light.radiance = radiance;
  light.probability = light.cumulative = 1;
  light.texture = kNoTexture;
  return light;
}

/// A disk of radius 0 is a point and has the area 1.
inline AreaLight disk(Float3 centre, Float3 normal, float radius, Float3 radiance = {2, 3, 5}) {
  Float3 s, t;
  basis_around(normalize(normal), s, t);
  AreaLight light = rectangle(centre, s * radius, t * radius, radiance);
  light.shape = LightShape::kDisk;
  light.normal = normalize(normal);
  light.area = radius > 0 ? kPi * radius * radius : 1.0f;
  return light;
}

inline AreaLight sphere(Float3 centre, float radius, Float3 radiance = {2, 3, 5}) {
  AreaLight light = disk(centre, {0, 0, 1}, radius, radiance);
  light.shape = LightShape::kSphere;
  return light;
}

}  // namespace diaphane::render::test
