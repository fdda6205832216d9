#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/math/vector.h"
#include "renderd/scene/grid.h"
#include "volume/alignment.h"
#include "volume/volume.h"

namespace diaphane::render {

/// A volume in the same box with fewer voxels, always in host memory.
struct CoarseVolume {
  volume::Volume volume;
  ValueGrid grid;
};
/// Returns a coarse copy by nearest voxels, with at most a million voxels.
std::shared_ptr<const CoarseVolume> coarse_of(const volume::Volume& volume);

/// The coarse copy of a session's second scan, and how it lies. Without a volume, there is none.
struct CoarseSecond {
  std::shared_ptr<const CoarseVolume> volume;
  volume::Matrix to_first = volume::kIdentity;
};

struct VisiblePoint {
  Double3 place;            ///< mm in world space
  double distance = 0;      ///< mm from the eye along the view axis
  std::uint32_t label = 0;  ///< number of the label at the place; 0: none
};

/// Returns the place at which half of what is visible at a point of the picture lies before and
/// half behind. For thin skin over bone, this is one of the two and never between them. `x` and `y`
/// range from 0 to 1 from the upper left. Returns nullopt if only background is visible.
/// Precondition: `scene` has passed check_scene.
std::optional<VisiblePoint> visible_point_at(const CoarseVolume& coarse,
                                             const diaphane::v1::Scene& scene, Canvas canvas,
                                             double x, double y, const CoarseSecond& second = {});

/// Returns for each place (mm in world space) whether matter or a slice in front of it hides it, so
/// that less than half of it could be seen. Places outside the picture count as well. A place on a
/// visible surface is not hidden. Precondition: `scene` has passed check_scene.
std::vector<bool> hidden_places(const CoarseVolume& coarse, const diaphane::v1::Scene& scene,
                                Canvas canvas, const std::vector<Double3>& places,
                                const CoarseSecond& second = {});

}  // namespace diaphane::render
