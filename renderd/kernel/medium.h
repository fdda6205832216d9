#pragma once

#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/views.h"
#include "renderd/math/vector.h"

namespace diaphane::render {

HOST_DEVICE float LinearVolume::at(Float3 p) const {
  // The lower corner of the cell between voxel centres, clamped so that a border voxel extends to
  // the edge of the box.
  const float fx = min(max(p.x - 0.5f, 0.0f), static_cast<float>(size.x - 1));
  const float fy = min(max(p.y - 0.5f, 0.0f), static_cast<float>(size.y - 1));
  const float fz = min(max(p.z - 0.5f, 0.0f), static_cast<float>(size.z - 1));
  const std::int32_t ix = static_cast<std::int32_t>(fx);
  const std::int32_t iy = static_cast<std::int32_t>(fy);
  const std::int32_t iz = static_cast<std::int32_t>(fz);
  const std::int32_t dx = ix + 1 < size.x ? 1 : 0;
  const std::int64_t dy = iy + 1 < size.y ? size.x : 0;
  const std::int64_t dz = iz + 1 < size.z ? std::int64_t{size.x} * size.y : 0;
  const std::int16_t* v = voxels + (ix + size.x * (iy + std::int64_t{size.y} * iz));
  const float wx = fx - static_cast<float>(ix);
  const float wy = fy - static_cast<float>(iy);
  const float wz = fz - static_cast<float>(iz);
  const float v000 = v[0], v100 = v[dx], v010 = v[dy], v110 = v[dy + dx];
  const float v001 = v[dz], v101 = v[dz + dx], v011 = v[dz + dy], v111 = v[dz + dy + dx];
  const float v00 = v000 + wx * (v100 - v000), v10 = v010 + wx * (v110 - v010);
  const float v01 = v001 + wx * (v101 - v001), v11 = v011 + wx * (v111 - v011);
  const float v0 = v00 + wy * (v10 - v00), v1 = v01 + wy * (v11 - v01);
  return v0 + wz * (v1 - v0);
}

HOST_DEVICE ValueSpan LinearVolume::corner_range(Int3 cell) const {
  const std::int32_t x0 = max(cell.x - 1, 0), x1 = min(cell.x, size.x - 1);
  const std::int32_t y0 = max(cell.y - 1, 0), y1 = min(cell.y, size.y - 1);
  const std::int32_t z0 = max(cell.z - 1, 0), z1 = min(cell.z, size.z - 1);
  const std::int64_t rows[4] = {y0 + std::int64_t{size.y} * z0, y1 + std::int64_t{size.y} * z0,
                                y0 + std::int64_t{size.y} * z1, y1 + std::int64_t{size.y} * z1};
  std::int16_t low = voxels[size.x * rows[0] + x0], high = low;
  for (const std::int64_t row : rows) {
    const std::int16_t a = voxels[size.x * row + x0], b = voxels[size.x * row + x1];
    low = min(low, min(a, b));
    high = max(high, max(a, b));
  }
  return {static_cast<float>(low), static_cast<float>(high)};
}

/// Indices of the voxels at the two ends of a cell along one axis, clamped to the volume. Rounding
/// may take a ray one cell beyond the last cell, which is cell `size`.
struct CellEnds {
  std::int32_t low, high;

  HOST_DEVICE CellEnds(std::int32_t cell, std::int32_t size)
      : low(min(max(cell - 1, 0), size - 1)), high(min(cell, size - 1)) {}
};

HOST_DEVICE Corners LinearVolume::corners(Int3 cell, Brick /*brick*/) const {
  const CellEnds x(cell.x, size.x), y(cell.y, size.y), z(cell.z, size.z);
  const std::int64_t row = size.x, slice = row * size.y;
  const std::int16_t* v00 = voxels + row * y.low + slice * z.low;
  const std::int16_t* v10 = voxels + row * y.high + slice * z.low;
  const std::int16_t* v01 = voxels + row * y.low + slice * z.high;
  const std::int16_t* v11 = voxels + row * y.high + slice * z.high;
  const auto number = [](std::int16_t v) { return static_cast<float>(v); };
  return {{number(v00[x.low]), number(v00[x.high]), number(v10[x.low]), number(v10[x.high]),
           number(v01[x.low]), number(v01[x.high]), number(v11[x.low]), number(v11[x.high])}};
}

HOST_DEVICE CornerRange LinearVolume::corner_values(Int3 cell, Brick brick) const {
  const Corners c = corners(cell, brick);
  float low = c.v[0], high = c.v[0];
  for (int i = 1; i < 8; ++i) {
    low = min(low, c.v[i]);
    high = max(high, c.v[i]);
  }
  return {static_cast<std::int32_t>(low), static_cast<std::int32_t>(high)};
}

/// A position in the transfer function's tables, between `node` and `node + 1`.
struct TableSpot {
  std::int32_t node;
  float weight;
};

HOST_DEVICE TableSpot table_spot(const TransferView& t, float value) {
  const float x = min(max(value * t.scale + t.offset, 0.0f), static_cast<float>(t.count - 1));
  const std::int32_t node = min(static_cast<std::int32_t>(x), t.count - 2);
  return {node, x - static_cast<float>(node)};
}

/// Returns the extinction at a value, per mm.
HOST_DEVICE float extinction_at(const TransferView& t, float value) {
  const TableSpot s = table_spot(t, value);
  const float a = t.extinction[s.node];
  return a + s.weight * (t.extinction[s.node + 1] - a);
}

/// Returns an upper bound of the extinction over a range of values, per mm. It is the largest of
/// all nodes around the range, found from two overlapping runs of 2^r nodes.
HOST_DEVICE float largest_extinction(const TransferView& t, ValueSpan values) {
  const float end = static_cast<float>(t.count - 1);
  const float low = values.low * t.scale + t.offset - t.margin;
  const float high = values.high * t.scale + t.offset + t.margin;
  const std::int32_t first = static_cast<std::int32_t>(min(max(low, 0.0f), end));
  const std::int32_t last =
      min(static_cast<std::int32_t>(min(max(high, 0.0f), end)) + 1, t.count - 1);
  std::int32_t row = 0, run = 1;
  while (2 * run <= last - first + 1) {
    run *= 2;
    ++row;
  }
  const float* maxima = t.extinction + std::int64_t{t.count} * row;
  constexpr float kRounding = 1 + 1e-6f;
  return max(maxima[first], maxima[last + 1 - run]) * kRounding;
}

/// Returns the mean colour at a position of a table of sums, xyz over w (TransferView::colour).
/// Returns black if no channel is active.
HOST_DEVICE Float3 mean_colour(const Float4* table, TableSpot s) {
  const Float4 a = table[s.node], b = table[s.node + 1];
  const float w = a.w + s.weight * (b.w - a.w);
  if (!(w > 0.0f)) return {0.0f, 0.0f, 0.0f};
  const Float3 sum{a.x + s.weight * (b.x - a.x), a.y + s.weight * (b.y - a.y),
                   a.z + s.weight * (b.z - a.z)};
  return sum * (1.0f / w);
}

/// Returns the single-scattering albedo at a value.
HOST_DEVICE Float3 albedo_at(const TransferView& t, float value) {
  return mean_colour(t.colour, table_spot(t, value));
}

/// Parameters of the microfacet lobe of surfaces.
struct Gloss {
  Float3 specular;  ///< reflectance at normal incidence
  float gloss;      ///< [0, 1]
};

/// Returns the gloss at a value, or no gloss if the scene has no table of it. That happens in a
/// kernel with more features than the scene needs.
HOST_DEVICE Gloss gloss_at(const TransferView& t, float value) {
  if (t.gloss == nullptr) return {};
  const TableSpot s = table_spot(t, value);
  const float low = t.colour[s.node].w;
  const float w = low + s.weight * (t.colour[s.node + 1].w - low);
  if (!(w > 0.0f)) return {};
  const Float4 a = t.gloss[s.node], b = t.gloss[s.node + 1];
  const Float3 sum{a.x + s.weight * (b.x - a.x), a.y + s.weight * (b.y - a.y),
                   a.z + s.weight * (b.z - a.z)};
  return {sum * (1.0f / w), (a.w + s.weight * (b.w - a.w)) / w};
}

/// Returns the source function at a value, which is the radiance of opaque matter. Thin matter
/// emits this radiance times the extinction per mm, so estimators add it where a path collides.
/// Returns black if the scene has no table of emission.
HOST_DEVICE Float3 emission_at(const TransferView& t, float value) {
  if (t.emission == nullptr) return {0.0f, 0.0f, 0.0f};
  return mean_colour(t.emission, table_spot(t, value));
}

}  // namespace diaphane::render
