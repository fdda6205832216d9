#pragma once

#include "renderd/kernel/phase.h"
#include "renderd/math/vector.h"

// Reflection of a surface: Lambert under a GGX microfacet lobe (Walter et al. 2007; Smith's
// height-correlated masking: Heitz 2014; visible normals by spherical caps: Dupuy and Benyoub
// 2023). All directions are unit vectors that point away from the surface, on the viewer's side.
//
// The Fresnel term is Schlick's with the value min(1, 50 F0) at grazing incidence, so that the
// lobe vanishes as F0 approaches 0. What the lobe does not reflect reaches the Lambert part, on the
// way in and out: (1 - F(view)) (1 - F(light)) / (1 - mean F) diffuse / pi (after Ashikhmin and
// Shirley 2000). This is reciprocal, and with a white diffuse colour the surface reflects at most
// all light. The model loses the light that facets would scatter twice, which matters for rough
// lobes.

namespace diaphane::render {

struct Brdf {
  Float3 normal;    ///< unit, mm, on the viewer's side
  Float3 viewer;    ///< unit, mm, towards the origin of the path
  Float3 diffuse;   ///< reflectance
  Float3 specular;  ///< reflectance of the lobe at normal incidence; black: no lobe
  float roughness;  ///< GGX alpha, at least kLeastRoughness with a lobe
};

/// Below this roughness fp32 directions cannot resolve the peak of the lobe.
inline constexpr float kLeastRoughness = 1e-3f;

HOST_DEVICE Float3 fresnel(Float3 at_normal, float cosine) {
  const float m = max(1.0f - cosine, 0.0f);
  const float m2 = m * m;
  const float k = m2 * m2 * m;
  const auto one = [k](float f) { return f + (min(1.0f, 50.0f * f) - f) * k; };
  return {one(at_normal.x), one(at_normal.y), one(at_normal.z)};
}

/// Returns the reciprocal of the mean of 1 - F over the directions of a Lambert surface, slightly
/// reduced. Without the reduction, a lobe of roughness 0.1 would reflect 1.0018 at 50 degrees.
HOST_DEVICE Float3 shared(Float3 at_normal) {
  const auto one = [](float f) {
    const float grazing = min(1.0f, 50.0f * f);
    const float mean = f + (grazing - f) * (1.0f / 21.0f);
    return mean < 1.0f ? (1.0f - 0.002f * grazing) / (1.0f - mean) : 0.0f;
  };
  return {one(at_normal.x), one(at_normal.y), one(at_normal.z)};
}

/// Returns the GGX density of the facets' normals, per steradian and projected area. The sine comes
/// from the cross product, because 1 - cos^2 would lose all digits in a narrow lobe.
HOST_DEVICE float ggx(float roughness, Float3 normal, Float3 facet) {
  const Float3 c = cross(normal, facet);
  const float a2 = roughness * roughness;
  const float cosine = dot(normal, facet);
  const float d = dot(c, c) + a2 * cosine * cosine;
  return a2 / (kPi * d * d);
}

/// Returns the term sqrt(a^2 + (1 - a^2) cos^2) of Smith's masking function.
HOST_DEVICE float ggx_masking(float roughness, float cosine) {
  const float a2 = roughness * roughness;
  return sqrtf(a2 + (1.0f - a2) * cosine * cosine);
}

/// Returns the probability with which sample_brdf() samples the lobe.
HOST_DEVICE float lobe_share(const Brdf& b, float cosine) {
  const Float3 f = fresnel(b.specular, cosine);
  const float lobe = max_component(f);
  const float rest = max_component(b.diffuse * (Float3{1.0f, 1.0f, 1.0f} - f));
  return lobe > 0.0f ? lobe / (lobe + rest) : 0.0f;
}

/// Samples the normal of a facet from the distribution of those visible to the viewer.
HOST_DEVICE Float3 sample_visible_normal(const Brdf& b, float u, float v) {
  Float3 s, t;
  basis_around(b.normal, s, t);
  const float a = b.roughness;
  const Float3 view = normalize(
      Float3{a * dot(b.viewer, s), a * dot(b.viewer, t), max(dot(b.viewer, b.normal), 0.0f)});
  const float z = (1.0f - v) * (1.0f + view.z) - view.z;
  const float sine = sqrtf(max(1.0f - z * z, 0.0f));
  const float angle = 2.0f * kPi * u;
  const Float3 h{sine * cosf(angle) + view.x, sine * sinf(angle) + view.y, z + view.z};
  return normalize(s * (a * h.x) + t * (a * h.y) + b.normal * max(h.z, 1e-7f));
}

/// Returns the BRDF times the cosine, per steradian. `Lobe` says whether there may be a lobe.
template <bool Lobe>
HOST_DEVICE Float3 evaluate_brdf(const Brdf& b, Float3 light) {
  const float out = dot(b.normal, light);
  if (!(out > 0.0f)) return {0.0f, 0.0f, 0.0f};
  const Float3 lambert = b.diffuse * (out * (1.0f / kPi));
  if constexpr (!Lobe) {
    return lambert;
  } else {
    if (!(max_component(b.specular) > 0.0f)) return lambert;
    const float in = max(dot(b.normal, b.viewer), 1e-6f);
    const Float3 one{1.0f, 1.0f, 1.0f};
    const Float3 below = lambert * (one - fresnel(b.specular, in)) *
                         (one - fresnel(b.specular, out)) * shared(b.specular);
    const Float3 facet = normalize(b.viewer + light);
    const float lobe = 0.5f * out * ggx(b.roughness, b.normal, facet) /
                       (out * ggx_masking(b.roughness, in) + in * ggx_masking(b.roughness, out));
    return below + fresnel(b.specular, dot(b.viewer, facet)) * lobe;
  }
}

/// Returns the density of sample_brdf() in the direction `light`, per steradian. Its integral is
/// below 1 if the lobe is wide, because sampled directions below the surface have no density.
template <bool Lobe>
HOST_DEVICE float brdf_density(const Brdf& b, Float3 light) {
  const float out = dot(b.normal, light);
  if (!(out > 0.0f)) return 0.0f;
  const float lambert = out * (1.0f / kPi);
  if constexpr (!Lobe) {
    return lambert;
  } else {
    if (!(max_component(b.specular) > 0.0f)) return lambert;
    const float in = max(dot(b.normal, b.viewer), 1e-6f);
    const float share = lobe_share(b, in);
    const Float3 facet = normalize(b.viewer + light);
    const float lobe =
        0.5f * ggx(b.roughness, b.normal, facet) / (in + ggx_masking(b.roughness, in));
    return lambert + share * (lobe - lambert);
  }
}

/// Samples the direction in which the path continues. A direction sampled from the lobe can lie
/// below the surface, where the path ends.
template <bool Lobe>
HOST_DEVICE Float3 sample_brdf(const Brdf& b, float u, float v) {
  if constexpr (Lobe) {
    if (max_component(b.specular) > 0.0f) {
      const float share = lobe_share(b, max(dot(b.normal, b.viewer), 1e-6f));
      if (u < share) {
        const Float3 facet = sample_visible_normal(b, u / share, v);
        return normalize(facet * (2.0f * dot(b.viewer, facet)) - b.viewer);
      }
      u = (u - share) / (1.0f - share);
    }
  }
  u = min(max(u, 0.0f), 0x1.fffffep-1f);
  Float3 s, t;
  basis_around(b.normal, s, t);
  const float r = sqrtf(u), angle = 2.0f * kPi * v;
  return s * (r * cosf(angle)) + t * (r * sinf(angle)) + b.normal * sqrtf(1.0f - u);
}

}  // namespace diaphane::render
