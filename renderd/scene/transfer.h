#pragma once

#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/exact_tables.h"
#include "renderd/scene/grid.h"

namespace diaphane::render {

/// The transfer function baked for one volume: tables over the volume's range of values and the
/// bounds of the extinction in each macrocell. Depends on nothing else of a scene, so a camera edit
/// reuses it.
struct PreparedTransfer {
  std::vector<float> extinction;  ///< TransferView::extinction, with its maxima
  std::vector<Float4> colour;     ///< TransferView::colour, `count` long
  std::vector<Float4> gloss;      ///< TransferView::gloss; empty when no channel has a lobe
  std::vector<Float4> emission;   ///< TransferView::emission; empty when none glows
  std::int32_t count = 0;         ///< TransferView, and the three below
  float scale = 0, offset = 0, margin = 0;
  float densest = 0;               ///< the largest extinction, per mm
  bool steep = false;              ///< needs Feature::kSteepExtinction
  Int3 cells{};                    ///< GridView::size
  std::vector<CellBounds> bounds;  ///< GridView::cells
  Box occupied{};                  ///< GridView::occupied
  ExactTables exact;               ///< for the exact walk; no pieces where there would be too many
};

/// What the transfer function is at one voxel value, exactly: the overlap rule of thesis 3.1.1.
struct Material {
  double opacity = 0;         ///< the largest of the channels'
  Double3 weighted_albedo{};  ///< sum of opacity times albedo
  double weight = 0;          ///< sum of the opacities
  // Sums of opacity times each.
  Double3 weighted_specular{};
  double weighted_gloss = 0;
  Double3 weighted_emission{};
};
Material material_at(const diaphane::v1::TransferFunction& function, double value);

/// `function` has passed check_scene; `size` in voxels, `spacing` in mm.
///
/// The tables span the volume's values with a node per 2^-k of a value unit: k = 0 for a CT's 12
/// bits, coarser for wider ranges (8192 nodes), finer where two points of a curve are closer than
/// two nodes (65536 nodes at most). A jump at a channel's end becomes a ramp one node wide.
/// Where the grid has no ranges (ValueGrid), only the tables are made, without rows of maxima: an
/// engine makes the rest on its device.
PreparedTransfer prepare_transfer(const diaphane::v1::TransferFunction& function,
                                  const ValueGrid& grid, Int3 size, Float3 spacing);

}  // namespace diaphane::render
