#pragma once

#include "renderd/kernel/views.h"
#include "renderd/math/vector.h"

namespace diaphane::render {

/// Light from one sampled point of a rectangle, before transmittance and phase function.
struct LightSample {
  Float3 direction;   ///< unit, from the lit place to the light
  float distance;     ///< mm
  Float3 irradiance;  ///< radiance times cosine times area over distance^2 over the light's
                      ///< probability
  bool lit;           ///< false: the place is behind the light
};

/// The index of the light for `u` in (0, 1); `u` is stretched again to (0, 1) for what comes next.
/// By bisection: there may be thousands.
HOST_DEVICE std::uint32_t pick_light(const LightsView& lights, float& u) {
  std::uint32_t low = 0, high = lights.count - 1;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (u < lights.area[middle].cumulative) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  const AreaLight& light = lights.area[low];
  u = smaller(larger((u - (light.cumulative - light.probability)) / light.probability, 0.0f),
              0x1.fffffep-1f);
  return low;
}

/// A point uniform over the light's area. `place` in mm in the volume's frame.
HOST_DEVICE LightSample sample_light(const AreaLight& light, Float3 place, float u, float v) {
  const Float3 to = light.corner + light.u * u + light.v * v - place;
  const float squared = dot(to, to);
  LightSample s{};
  const float facing = -dot(light.normal, to);  // cosine times distance
  if (!(facing > 0.0f) || !(squared > 0.0f)) return s;
  const float distance = sqrtf(squared);
  s.direction = to * (1.0f / distance);
  s.distance = distance;
  s.irradiance = light.radiance * (facing / distance / squared * light.area / light.probability);
  s.lit = true;
  return s;
}

}  // namespace diaphane::render
