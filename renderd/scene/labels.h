#pragma once

#include <array>
#include <memory>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/transfer.h"

namespace diaphane::render {

/// The least and largest opacity of the labels of a macrocell.
struct LabelRange {
  float least, most;
};

/// The looks of the labels of one volume, and what follows from them and the transfer function.
struct PreparedLabels {
  std::array<LabelLook, 256> looks;  ///< LabelsView::looks
  std::vector<LabelRange> ranges;    ///< by LabelGrid::sets
  std::vector<CellBounds> bounds;    ///< as in PreparedTransfer, and empty under the same condition
  Box occupied{};                    ///< as in PreparedTransfer
  bool steep = false;                ///< as in PreparedTransfer
};

/// Prepares the labels of a scene that has passed check_scene(). Returns null if they change
/// nothing, so that the scene needs no Feature::kLabels. `size` is in voxels, `spacing` in mm.
std::shared_ptr<const PreparedLabels> prepare_labels(const diaphane::v1::Scene& scene,
                                                     const PreparedTransfer& transfer,
                                                     const LabelGrid& grid, Int3 size,
                                                     Float3 spacing);

/// Returns whether two scenes show labels in the same way.
bool have_same_labels(const diaphane::v1::Scene& a, const diaphane::v1::Scene& b);

}  // namespace diaphane::render
