#pragma once

#include <memory>
#include <vector>

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/transfer.h"
#include "volume/alignment.h"

namespace diaphane::render {

/// The second scan of a session as an engine holds it, and how it lies.
struct SecondScan {
  const volume::Header& header;
  const ValueGrid& grid;
  const volume::Matrix& to_first;  ///< as in SecondScan of api/proto/worker.proto
  TransferCache* baked = nullptr;  ///< may be null
  bool as_before = false;          ///< the previous scene had the same, in the same place
};

/// The second scan of one scene. The pointers and the volume of `view` are those of the engine.
struct PreparedOverlay {
  std::shared_ptr<const PreparedTransfer> transfer;  ///< by the values of the second scan
  OverlayView<LinearVolume> view{};                  ///< without volume, tables and majorants
  Int3 size{};                                       ///< of the second scan, in voxels
  /// By macrocell of the first scan: of the second scan alone, and of both. Empty if the grids have
  /// no ranges, because the engine computes them on its device.
  std::vector<float> majorants;
  std::vector<CellBounds> bounds;
  Box occupied{};      ///< as in PreparedTransfer, of both scans
  bool steep = false;  ///< likewise
};

/// Returns SceneView::surfaces. The scene's scale applies to gradients of the opacity, the kernel's
/// to gradients of the extinction, which is `densest` at opacity 1.
float surfaces_of(const diaphane::v1::Shading& shading, double densest);

/// Returns the factor of the extinction that leaves the share `keep` in [0, 1] of the opacity of a
/// layer of 100 mm, about half a head or trunk. A factor of `keep` itself would leave dense matter
/// opaque almost to the end.
double extinction_share(double keep, double densest);

/// Prepares the second scan of a scene that has passed check_scene(). Returns null if only the
/// first scan is shown. `bounds` are those of the first scan (bounds_of()), whose transfer function
/// is `first`. `width` is that of the picture in pixels.
std::shared_ptr<const PreparedOverlay> prepare_overlay(const diaphane::v1::Scene& scene,
                                                       const PreparedTransfer& first,
                                                       const std::vector<CellBounds>& bounds,
                                                       const volume::Header& header,
                                                       std::uint32_t width,
                                                       const SecondScan& second);

}  // namespace diaphane::render
