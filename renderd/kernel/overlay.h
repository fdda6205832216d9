#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/labels.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

// Two scans in one space (Feature::kOverlay). Their matter is a mixture: the extinctions add up,
// and a collision belongs to either scan in proportion to its extinction there. The second scan
// keeps its own voxels, which are looked up through an affine map of voxel indices.

namespace diaphane::render {

/// The factors of the extinctions of both scans on one path. They are empty without an overlay, so
/// that nothing is passed along.
template <bool Overlaid>
struct MatterShares {};
template <>
struct MatterShares<true> {
  float first, second;
};
template <Features F>
using SharesOf = MatterShares<F.has(Feature::kOverlay)>;

/// Returns the shares of the path that starts in column `x` of the picture. If the picture is
/// split, each path meets the matter of one scan only.
template <Features F, typename Volume>
HOST_DEVICE SharesOf<F> shares_at(const SceneView<Volume>& scene, [[maybe_unused]] float x) {
  if constexpr (F.has(Feature::kOverlay)) {
    const OverlayView<Volume>& o = scene.overlay;
    if (!o.split) return {o.first_share, o.second_share};
    return x < o.split_column ? MatterShares<true>{1.0f, 0.0f} : MatterShares<true>{0.0f, 1.0f};
  } else {
    return {};
  }
}

/// Returns the place in the second scan of a place in the first, both in voxel indices.
HOST_DEVICE Float3 in_second(const AffineMap& map, Float3 p) {
  return {dot(map.rows[0], p) + map.shift.x, dot(map.rows[1], p) + map.shift.y,
          dot(map.rows[2], p) + map.shift.z};
}

HOST_DEVICE bool is_inside(Int3 size, Float3 p) {
  return p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f && p.x <= static_cast<float>(size.x) &&
         p.y <= static_cast<float>(size.y) && p.z <= static_cast<float>(size.z);
}

/// Returns bounds of the second scan's extinction in a macrocell of the first, from the bounds of
/// the second scan's own macrocells, of which there are `cells` over `size` voxels. The result
/// holds half a voxel of the first scan beyond the cell as well, because rounding may put a place
/// there.
HOST_DEVICE CellBounds second_bounds(const AffineMap& map, Int3 cell, const CellBounds* bounds,
                                     Int3 cells, Int3 size) {
  constexpr float kHalf = 0.5f * kCellSize + 0.5f;
  const Float3 middle{(static_cast<float>(cell.x) + 0.5f) * kCellSize,
                      (static_cast<float>(cell.y) + 0.5f) * kCellSize,
                      (static_cast<float>(cell.z) + 0.5f) * kCellSize};
  const Float3 centre = in_second(map, middle);
  Int3 first{}, last{};
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const Float3 row = map.rows[axis];
    const float reach = kHalf * (fabsf(row.x) + fabsf(row.y) + fabsf(row.z));
    const float low = centre[axis] - reach, high = centre[axis] + reach;
    const float end = static_cast<float>(axis == 0 ? size.x : axis == 1 ? size.y : size.z);
    const std::int32_t count = axis == 0 ? cells.x : axis == 1 ? cells.y : cells.z;
    if (!(high >= 0.0f && low <= end)) return {0.0f, 0.0f};
    inside = inside && low >= 0.0f && high <= end;
    const auto cell_at = [count](float p) {
      return min(static_cast<std::int32_t>(max(p, 0.0f)) >> kCellShift, count - 1);
    };
    const std::int32_t from = cell_at(low), to = cell_at(min(high, end));
    (axis == 0 ? first.x : axis == 1 ? first.y : first.z) = from;
    (axis == 0 ? last.x : axis == 1 ? last.y : last.z) = to;
  }
  CellBounds result{3.4e38f, 0.0f};
  for (std::int32_t z = first.z; z <= last.z; ++z) {
    for (std::int32_t y = first.y; y <= last.y; ++y) {
      for (std::int32_t x = first.x; x <= last.x; ++x) {
        const CellBounds b = bounds[x + std::int64_t{cells.x} * (y + std::int64_t{cells.y} * z)];
        result.minorant = min(result.minorant, b.minorant);
        result.majorant = max(result.majorant, b.majorant);
      }
    }
  }
  if (!inside) result.minorant = 0.0f;
  return result;
}

/// Returns the bounds of the extinction of both scans in a macrocell on any path of the picture.
HOST_DEVICE CellBounds mixed_bounds(CellBounds first, CellBounds second, bool split,
                                    MatterShares<true> shares) {
  if (split) {
    return {min(first.minorant, second.minorant), max(first.majorant, second.majorant)};
  }
  // The sum of rounded products may exceed the rounded sum of bounds, which is why it is widened.
  constexpr float kRounding = 1 + 1e-6f;
  return {(first.minorant * shares.first + second.minorant * shares.second) / kRounding,
          (first.majorant * shares.first + second.majorant * shares.second) * kRounding};
}

/// A mixture of the first scan's medium and of the matter of the second scan.
template <typename First, typename Volume>
struct OverlaidMedium {
  static constexpr bool kTwoScans = true;

  First first;
  const Volume& volume;  ///< of the first scan
  const OverlayView<Volume>& overlay;
  MatterShares<true> shares;

  HOST_DEVICE float first_extinction(float value, Float3 place) const {
    return shares.first > 0.0f ? shares.first * first.extinction(value, place) : 0.0f;
  }
  HOST_DEVICE float second_value(Float3 place) const {
    return overlay.volume.at(in_second(overlay.map, place));
  }
  HOST_DEVICE float second_extinction(Float3 place) const {
    if (!(shares.second > 0.0f)) return 0.0f;
    const Float3 there = in_second(overlay.map, place);
    if (!is_inside(overlay.volume.size, there)) return 0.0f;
    return shares.second * extinction_at(overlay.transfer, overlay.volume.at(there));
  }
  HOST_DEVICE float extinction(float value, Float3 place) const {
    return first_extinction(value, place) + second_extinction(place);
  }
  /// As in Medium. The bound of the second scan is that of the whole macrocell.
  HOST_DEVICE float majorant(Int3 cell, std::int32_t macrocell) const {
    constexpr float kRounding = 1 + 1e-6f;
    const float one = shares.first > 0.0f ? shares.first * first.majorant(cell, macrocell) : 0.0f;
    if (!(shares.second > 0.0f)) return one;
    return (one + shares.second * overlay.majorants[macrocell]) * kRounding;
  }
};

/// Returns the medium of a path with these shares.
template <Features F, typename Volume>
HOST_DEVICE auto medium_of(const SceneView<Volume>& scene, SharesOf<F> shares) {
  if constexpr (F.has(Feature::kOverlay)) {
    using First = decltype(first_medium_of<F>(scene));
    return OverlaidMedium<First, Volume>{first_medium_of<F>(scene), scene.volume, scene.overlay,
                                         shares};
  } else {
    return first_medium_of<F>(scene);
  }
}

}  // namespace diaphane::render
