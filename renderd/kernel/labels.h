#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"

namespace diaphane::render {

/// Returns how the voxel with this index is shown. Indices are clamped to the volume. A kernel with
/// more features than the scene needs may run without labels; then no voxel changes its
/// appearance.
HOST_DEVICE LabelLook look_of_voxel(const LabelsView& labels, Int3 size, Int3 voxel) {
  if (labels.voxels == nullptr) return kUnchangedLook;
  const std::int64_t x = min(max(voxel.x, 0), size.x - 1);
  const std::int64_t y = min(max(voxel.y, 0), size.y - 1);
  const std::int64_t z = min(max(voxel.z, 0), size.z - 1);
  return labels.looks[labels.voxels[x + size.x * (y + size.y * z)]];
}

/// Returns how the matter at a place (voxel indices) is shown: like the voxel that contains it,
/// because labels cannot be interpolated.
HOST_DEVICE LabelLook look_at(const LabelsView& labels, Int3 size, Float3 place) {
  // The conversion rounds towards 0, which is harmless below 0, because indices are clamped.
  return look_of_voxel(labels, size,
                       Int3{static_cast<std::int32_t>(place.x), static_cast<std::int32_t>(place.y),
                            static_cast<std::int32_t>(place.z)});
}

/// A medium whose extinction is the transfer function of the interpolated voxel value.
template <typename Volume>
struct Medium {
  static constexpr bool kTwoScans = false;

  const Volume& volume;
  const TransferView& transfer;

  HOST_DEVICE float extinction(float value, Float3 /*place*/) const {
    return extinction_at(transfer, value);
  }
  /// Returns an upper bound of the extinction in the part of a cell between voxel centres
  /// (VoxelWalk) that lies in a macrocell.
  HOST_DEVICE float majorant(Int3 cell, std::int32_t /*macrocell*/) const {
    return largest_extinction(transfer, volume.corner_range(cell));
  }
};

/// A medium whose extinction is that of Medium times the opacity of the label at the place.
template <typename Volume>
struct LabelledMedium {
  static constexpr bool kTwoScans = false;

  const Volume& volume;
  const TransferView& transfer;
  const LabelsView& labels;

  HOST_DEVICE float extinction(float value, Float3 place) const {
    return look_at(labels, volume.size, place).opacity * extinction_at(transfer, value);
  }
  HOST_DEVICE float majorant(Int3 cell, std::int32_t /*macrocell*/) const {
    // The cell overlaps the eight voxels at its corners, each of which may have another label.
    float most = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
      const Int3 voxel{cell.x - (corner & 1), cell.y - (corner >> 1 & 1), cell.z - (corner >> 2)};
      most = max(most, look_of_voxel(labels, volume.size, voxel).opacity);
    }
    return most > 0.0f ? most * largest_extinction(transfer, volume.corner_range(cell)) : 0.0f;
  }
};

/// Returns the albedo of the matter at a place (voxel indices), given its albedo by the transfer
/// function. A label may replace it, and a highlight tints it.
template <typename Volume>
HOST_DEVICE Float3 albedo_of(const SceneView<Volume>& scene, Float3 place, const LabelLook& look,
                             Float3 albedo) {
  if (!(look.colour.x < 0.0f)) albedo = look.colour;
  const HighlightView& highlight = scene.highlight;
  if (!(highlight.strength > 0.0f)) return albedo;
  const Float3 from_centre = place * scene.spacing - highlight.centre;
  if (dot(from_centre, from_centre) > highlight.squared_radius) return albedo;
  return albedo + (highlight.colour - albedo) * highlight.strength;
}

/// Returns the medium of the first scan. See medium_of() in overlay.h.
template <Features F, typename Volume>
HOST_DEVICE auto first_medium_of(const SceneView<Volume>& scene) {
  if constexpr (F.has(Feature::kLabels)) {
    return LabelledMedium<Volume>{scene.volume, scene.transfer, scene.labels};
  } else {
    return Medium<Volume>{scene.volume, scene.transfer};
  }
}

}  // namespace diaphane::render
