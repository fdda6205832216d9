#pragma once

#include "renderd/kernel/phase.h"
#include "renderd/kernel/views.h"
#include "renderd/math/vector.h"

// Pictures on lights: bilinear lookup, and sampling of directions from environment maps.

namespace diaphane::render {

/// A point of a picture, in [0, 1] from left to right and from top to bottom.
struct TexturePoint {
  float across, down;
};

/// Returns the point of a latitude-longitude map for the unit direction with these components.
HOST_DEVICE TexturePoint map_point(float right, float middle, float up) {
  // The arc cosine of `up` would have only four digits near the poles.
  const float flat = sqrtf(right * right + middle * middle);
  return {0.5f + atan2f(right, middle) * (0.5f / kPi), atan2f(flat, up) * (1.0f / kPi)};
}

enum class TextureEdge { kClamp, kWrapAcross };

/// Returns the colour at `p` by bilinear interpolation between the centres of the texels.
template <TextureEdge Edge>
HOST_DEVICE Float3 colour_at(const LightsView& lights, const LightTexture& texture,
                             TexturePoint p) {
  const float across = p.across * static_cast<float>(texture.width) - 0.5f;
  const float down = p.down * static_cast<float>(texture.height) - 0.5f;
  const float x = floorf(across), y = floorf(down);
  const float wx = across - x, wy = down - y;
  const auto column = [&](std::int32_t i) {
    const std::int32_t last = texture.width - 1;
    if constexpr (Edge == TextureEdge::kWrapAcross) return i < 0 ? last : (i > last ? 0 : i);
    return min(max(i, 0), last);
  };
  const auto row = [&](std::int32_t j) { return min(max(j, 0), texture.height - 1); };
  const std::int32_t i0 = column(static_cast<std::int32_t>(x));
  const std::int32_t i1 = column(static_cast<std::int32_t>(x) + 1);
  const std::int32_t j0 = row(static_cast<std::int32_t>(y));
  const std::int32_t j1 = row(static_cast<std::int32_t>(y) + 1);
  const auto texel = [&](std::int32_t i, std::int32_t j) {
    const Float4 c =
        lights.texels[texture.first_texel + static_cast<std::uint32_t>(i + j * texture.width)];
    return Float3{c.x, c.y, c.z};
  };
  const Float3 above = texel(i0, j0) * (1.0f - wx) + texel(i1, j0) * wx;
  const Float3 below = texel(i0, j1) * (1.0f - wx) + texel(i1, j1) * wx;
  return above * (1.0f - wy) + below * wy;
}

/// Returns the first of `count` indices whose `cumulative(i)` is above u. The last value of
/// `cumulative` must be above u.
template <typename Cumulative>
HOST_DEVICE std::uint32_t first_above(std::uint32_t count, float u, const Cumulative& cumulative) {
  std::uint32_t low = 0, high = count - 1;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (u < cumulative(middle)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

/// Rescales `u` from [cumulative - probability, cumulative) to [0, 1), so that it can be used
/// again.
HOST_DEVICE float stretched(float u, float probability, float cumulative) {
  return min(max((u - (cumulative - probability)) / probability, 0.0f), 0x1.fffffep-1f);
}

/// sin^2 and cos^2 of half the polar angle at the upper edge of row `j` of `height`. They range
/// from 0 to 1 and from 1 to 0, are uniform over the sphere, and each is exact near its zero.
struct RowEdge {
  float sine2, cosine2;
};
HOST_DEVICE RowEdge row_edge(std::int32_t j, std::int32_t height) {
  const float angle =
      static_cast<float>(j) * (0.5f * kPi) / static_cast<float>(height);  // 0 to pi / 2
  const float other = static_cast<float>(height - j) * (0.5f * kPi) / static_cast<float>(height);
  const float s = sinf(angle), c = sinf(other);
  return {s * s, c * c};
}

/// Returns the solid angle of a texel in row `j` of a latitude-longitude map. The difference of the
/// cosines is computed as a product, which does not cancel at the poles.
HOST_DEVICE float texel_solid_angle(std::int32_t j, const LightTexture& texture) {
  const float half = 0.5f * kPi / static_cast<float>(texture.height);
  return 4.0f * kPi / static_cast<float>(texture.width) *
         (sinf(static_cast<float>(2 * j + 1) * half) * sinf(half));
}

/// Samples a direction in the map's frame (right, middle, up), with the probabilities of the
/// texels, uniform in solid angle within a texel.
HOST_DEVICE Float3 sample_map(const LightsView& lights, const LightTexture& texture, float u,
                              float v) {
  const float* rows = lights.rows + texture.first_row;
  const std::uint32_t j = first_above(static_cast<std::uint32_t>(texture.height), v,
                                      [&](std::uint32_t i) { return rows[i]; });
  v = stretched(v, rows[j] - (j > 0 ? rows[j - 1] : 0.0f), rows[j]);
  const Float4* row =
      lights.texels + texture.first_texel + j * static_cast<std::uint32_t>(texture.width);
  const std::uint32_t i = first_above(static_cast<std::uint32_t>(texture.width), u,
                                      [&](std::uint32_t k) { return row[k].w; });
  u = stretched(u, row[i].w - (i > 0 ? row[i - 1].w : 0.0f), row[i].w);
  const RowEdge above = row_edge(static_cast<std::int32_t>(j), texture.height);
  const RowEdge below = row_edge(static_cast<std::int32_t>(j) + 1, texture.height);
  const float sine2 = above.sine2 + v * (below.sine2 - above.sine2);
  const float cosine2 = above.cosine2 + v * (below.cosine2 - above.cosine2);
  const float flat = 2.0f * sqrtf(sine2 * cosine2);
  const float longitude =
      2.0f * kPi * ((static_cast<float>(i) + u) / static_cast<float>(texture.width) - 0.5f);
  return {flat * sinf(longitude), flat * cosf(longitude), cosine2 - sine2};
}

/// Returns the density of sample_map() at a point of the map, per steradian.
HOST_DEVICE float map_density(const LightsView& lights, const LightTexture& texture,
                              TexturePoint p) {
  const auto cell = [](float x, std::int32_t n) {
    return min(max(static_cast<std::int32_t>(x * static_cast<float>(n)), 0), n - 1);
  };
  const std::int32_t i = cell(p.across, texture.width), j = cell(p.down, texture.height);
  const float* rows = lights.rows + texture.first_row;
  const Float4* row = lights.texels + texture.first_texel +
                      static_cast<std::uint32_t>(j) * static_cast<std::uint32_t>(texture.width);
  const float in_row = rows[j] - (j > 0 ? rows[j - 1] : 0.0f);
  const float in_texel = row[i].w - (i > 0 ? row[i - 1].w : 0.0f);
  return in_row * in_texel / texel_solid_angle(j, texture);
}

}  // namespace diaphane::render
