#pragma once

#include <vector>

#include "api/proto/scene.pb.h"
#include "api/proto/stream.pb.h"
#include "renderd/math/vector.h"
#include "renderd/session/depth.h"

namespace diaphane::render {

/// A direction from which to look at the visible matter, in degrees.
struct GoodView {
  double azimuth = 0;    ///< from the patient's left (x) towards their back (y), -180 to 180
  double elevation = 0;  ///< of the eye above the horizon
  double entropy = 0;    ///< of what is visible, in bits
};

struct GoodViews {
  std::vector<GoodView> views;  ///< by rising azimuth
  Double3 low, high;            ///< corners of the box around all visible matter, mm in world space
};

/// Returns the views of a scene from which most of its matter can be seen (docs/adr/0037): 5 to 8
/// all around the patient, or none if nothing is visible. Neighbours are 45 to 75 degrees of
/// azimuth apart. The time does not depend on the size of the volume. Precondition: `scene` has
/// passed check_scene.
GoodViews good_views(const CoarseVolume& coarse, const diaphane::v1::Scene& scene,
                     const CoarseSecond& second = {});

diaphane::v1::GoodViews to_proto(const GoodViews& views);

}  // namespace diaphane::render
