#pragma once

#include <cstdint>

#include "renderd/engine/cuda/acceleration_kernels.h"
#include "renderd/engine/cuda/memory.h"
#include "renderd/engine/cuda/volume.h"
#include "renderd/scene/labels.h"
#include "renderd/scene/overlay.h"
#include "renderd/scene/transfer.h"

namespace diaphane::render::cuda {

/// The device data that depends on both a volume and one renderer's transfer function: the
/// extinction and its maxima, the bounds of every macrocell, and the box around all cells that are
/// not empty. After an edit of the transfer function, only its table is uploaded. The value ranges
/// of the cells stay on the device with the volume.
///
/// Any other data that depends on both voxels and transfer function belongs here. reserve() must
/// allocate it, and rebuild_acceleration() must compute it.
class Acceleration {
 public:
  /// Allocates memory for a transfer function of this size. Returns a new object if `current` is
  /// too small, and an empty result if it is large enough. After kOutOfMemory, nothing has changed.
  static Result<Acceleration> reserve(const Acceleration& current, const CudaVolume& volume,
                                      const PreparedTransfer& transfer);
  bool made() const { return bounds_.data() != nullptr; }

  /// Uploads the extinction and recomputes everything else, in the order of the stream. `labels` is
  /// null if the scene has none. Waits for the result, because it decides which kernel is used.
  Result<void> rebuild_acceleration(const CudaVolume& volume, const PreparedTransfer& transfer,
                                    const PreparedLabels* labels, cudaStream_t stream);
  /// Adds the second scan to the bounds. `second` must be rebuilt for its own volume. Call it after
  /// rebuild_acceleration(). Waits for the result, likewise.
  Result<void> add_second(const Acceleration& second, const PreparedOverlay& overlay,
                          cudaStream_t stream);
  /// Returns OverlayView::majorants, which is valid after add_second().
  const float* majorants() const { return majorants_.data(); }
  /// Returns LabelsView::looks, which is valid if the last rebuild had labels.
  const LabelLook* looks() const { return looks_.data(); }

  /// Uploads and computes the data of the exact walk. Call it after rebuild_acceleration(), and
  /// only if the scene uses the exact walk.
  Result<void> rebuild_exact(const CudaVolume& volume, const ExactTables& tables,
                             cudaStream_t stream);
  const ExtinctionPiece* pieces() const { return pieces_.data(); }
  const std::uint16_t* piece_of() const { return piece_of_.data(); }
  const std::uint8_t* skips() const { return skips_.data(); }

  const float* extinction() const { return maxima_.data(); }
  const CellBounds* bounds() const { return bounds_.data(); }
  Int3 cells() const { return cells_; }
  /// Returns the box around all cells that are not empty, in voxels; empty if there are none.
  Box occupied() const;
  /// Returns whether the scene needs Feature::kSteepExtinction, in the same way as is_steep() in
  /// scene/transfer.cpp.
  bool steep(Float3 spacing) const;
  /// Returns the fraction of the cells that are skipped.
  double empty_cells() const;
  std::uint64_t device_bytes() const;

 private:
  Int3 size_{}, cells_{};
  CellSummary found_ = kNothingFound;
  DeviceBuffer<float> maxima_, minima_;  ///< TableRows
  DeviceBuffer<CellBounds> bounds_;
  DeviceBuffer<CellSummary> summary_;
  DeviceBuffer<float> majorants_;  ///< empty if there was never a second scan
  // Empty if the volume has no labels.
  DeviceBuffer<LabelLook> looks_;
  DeviceBuffer<LabelRange> label_ranges_;
  // For the exact walk; empty if it was never used.
  DeviceBuffer<ExtinctionPiece> pieces_;
  DeviceBuffer<std::uint16_t> piece_of_;
  DeviceBuffer<std::int32_t> clear_until_;
  DeviceBuffer<std::uint8_t> skips_;
  double empty_bricks_ = 0;
};

}  // namespace diaphane::render::cuda
