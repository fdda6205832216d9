#pragma once

#include <memory>
#include <optional>

#include "api/proto/scene.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/math/vector.h"
#include "renderd/scene/grid.h"
#include "volume/volume.h"

namespace diaphane::render {

/// A volume in the same box with fewer voxels, kept on the host wherever the renderer's own lies.
struct CoarseVolume {
  volume::Volume volume;
  ValueGrid grid;
};
/// Of the voxels nearest to its own, a million at most.
std::shared_ptr<const CoarseVolume> coarse_of(const volume::Volume& volume);

struct SeenPlace {
  Double3 place;        ///< mm in world space
  double distance = 0;  ///< mm from the eye along the view axis
};

/// Where half of what is seen at a point of the picture lies before and half behind: of a thin skin
/// over bone it is one or the other, never between. `x` and `y` from 0 to 1, from the upper left;
/// `scene` has passed check_scene. Nothing where only background is seen.
std::optional<SeenPlace> seen_at(const CoarseVolume& coarse, const diaphane::v1::Scene& scene,
                                 Canvas canvas, double x, double y);

}  // namespace diaphane::render
