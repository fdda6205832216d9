#pragma once

#include <array>

#include "volume/volume.h"

namespace diaphane::render {

/// The ellipsoid on which a preset frames its picture.
struct Framing {
  std::array<double, 3> centre{};      ///< mm, in world coordinates (api/proto/scene.proto)
  std::array<double, 3> half_width{};  ///< mm, along the axes of the volume
};

/// Returns the ellipsoid that touches all faces of the volume's box.
Framing whole_box(const volume::Header& header);

/// Returns the ellipsoid in the box between two corners in voxels, along the axes of the volume.
Framing box_framing(const volume::Header& header, const std::array<double, 3>& low,
                    const std::array<double, 3>& high);

/// Returns the ellipsoid in the box around what is denser than air (CT) or brighter than the
/// background (everything else). A thousandth of these voxels may lie outside at each face, so that
/// noise does not enlarge it. If there are next to none, returns whole_box().
Framing visible_part(const volume::Volume& volume);

}  // namespace diaphane::render
