#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/exact_tables.h"
#include "renderd/scene/grid.h"

namespace diaphane::render {

/// The transfer function baked for one volume: tables over the volume's range of values and bounds
/// of the extinction in each macrocell. It depends on nothing else in a scene, so a change of the
/// camera reuses it.
struct PreparedTransfer {
  std::vector<float> extinction;  ///< as TransferView::extinction, with its maxima
  std::vector<Float4> colour;     ///< as TransferView::colour, `count` entries
  std::vector<Float4> gloss;      ///< as TransferView::gloss; empty if no channel has a lobe
  std::vector<Float4> emission;   ///< as TransferView::emission; empty if no channel glows
  std::int32_t count = 0;         ///< as in TransferView, like the three below
  float scale = 0, offset = 0, margin = 0;
  float densest = 0;               ///< largest extinction, per mm
  bool steep = false;              ///< requires Feature::kSteepExtinction
  Int3 cells{};                    ///< GridView::size
  std::vector<CellBounds> bounds;  ///< GridView::cells
  Box occupied{};                  ///< GridView::occupied
  ExactTables exact;  ///< tables of the exact walk; without pieces if there would be too many
};

/// Returns whether the bounds of some macrocell are so far apart that a ray may need many steps in
/// it.
bool is_steep(const std::vector<CellBounds>& bounds, Float3 spacing);
/// Returns GridView::occupied. `size` is in voxels.
Box occupied_box(const std::vector<CellBounds>& bounds, Int3 cells, Int3 size);

/// The exact value of the transfer function at one voxel value, by the overlap rule of thesis
/// 3.1.1.
struct Material {
  double opacity = 0;         ///< the largest opacity of the channels
  Double3 weighted_albedo{};  ///< sum of opacity times albedo
  double weight = 0;          ///< sum of the opacities
  // Sums of opacity times the property.
  Double3 weighted_specular{};
  double weighted_gloss = 0;
  Double3 weighted_emission{};
};
Material material_at(const diaphane::v1::TransferFunction& function, double value);

/// Bakes a transfer function, which must have passed check_scene(). `size` is in voxels, `spacing`
/// in mm.
///
/// The tables span the volume's values with a node per 2^-k of a value unit. k is 0 for the 12 bits
/// of a CT, smaller for wider ranges (8192 nodes), and larger where two points of a curve are
/// closer than two nodes (at most 65536 nodes). A jump at the end of a channel becomes a ramp one
/// node wide. If the grid has no ranges (ValueGrid), only the tables are made, without rows of
/// maxima: an engine computes the rest on its device.
PreparedTransfer prepare_transfer(const diaphane::v1::TransferFunction& function,
                                  const ValueGrid& grid, Int3 size, Float3 spacing);

/// The transfer functions that were baked last for one volume. All pictures of the volume share
/// them, so that a scan whose phases are played does not bake one for each phase that returns.
/// Thread-safe.
class TransferCache {
 public:
  std::shared_ptr<const PreparedTransfer> get(const diaphane::v1::TransferFunction& function,
                                              const ValueGrid& grid, Int3 size, Float3 spacing);

 private:
  struct Baked {
    std::string function;
    std::shared_ptr<const PreparedTransfer> transfer;
  };
  std::mutex mutex_;
  std::vector<Baked> baked_;  ///< newest last
};

}  // namespace diaphane::render
