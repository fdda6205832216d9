#pragma once

#include <cstdint>

#include "renderd/engine/cuda_acceleration_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_volume.h"
#include "renderd/scene/transfer.h"

namespace diaphane::render::cuda {

/// What one renderer's transfer function makes of a volume, on the device: extinction with its
/// maxima, bounds of every macrocell, the box around what is not empty. An edit uploads the table
/// alone; the ranges of values that cells are bounded by lie on the device with the volume.
///
/// Whatever else depends on both voxels and transfer function belongs here: memory in reserve(),
/// work in rebuild_acceleration().
class Acceleration {
 public:
  /// Memory for a transfer function of this size: a new object where `current` is too small, and
  /// nothing where it is not. kOutOfMemory harms nothing.
  static Result<Acceleration> reserve(const Acceleration& current, const CudaVolume& volume,
                                      const PreparedTransfer& transfer);
  bool made() const { return bounds_.data() != nullptr; }

  /// Uploads the extinction and makes everything anew, in the stream's order; waits for it, because
  /// what was found decides which kernel is used.
  Result<void> rebuild_acceleration(const CudaVolume& volume, const PreparedTransfer& transfer,
                                    cudaStream_t stream);

  /// The same for the exact walk: where the walk will be used, after rebuild_acceleration().
  Result<void> rebuild_exact(const CudaVolume& volume, const ExactTables& tables,
                             cudaStream_t stream);
  const ExtinctionPiece* pieces() const { return pieces_.data(); }
  const std::uint16_t* piece_of() const { return piece_of_.data(); }
  const std::uint8_t* skips() const { return skips_.data(); }

  const float* extinction() const { return maxima_.data(); }
  const CellBounds* bounds() const { return bounds_.data(); }
  Int3 cells() const { return cells_; }
  /// In voxels; empty when all is.
  Box occupied() const;
  /// Whether Feature::kSteepExtinction is needed: as is_steep of scene/transfer.cpp.
  bool steep(Float3 spacing) const;
  /// Share of the cells that are skipped.
  double empty_cells() const;
  std::uint64_t device_bytes() const;

 private:
  Int3 size_{}, cells_{};
  CellSummary found_ = kNothingFound;
  DeviceBuffer<float> maxima_, minima_;  ///< TableRows
  DeviceBuffer<CellBounds> bounds_;
  DeviceBuffer<CellSummary> summary_;
  // Of the exact walk; nothing where it was never used.
  DeviceBuffer<ExtinctionPiece> pieces_;
  DeviceBuffer<std::uint16_t> piece_of_;
  DeviceBuffer<std::int32_t> clear_until_;
  DeviceBuffer<std::uint8_t> skips_;
  double empty_bricks_ = 0;
};

}  // namespace diaphane::render::cuda
