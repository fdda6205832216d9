#pragma once

#include <cuda_runtime_api.h>

#include <memory>
#include <mutex>

#include "renderd/engine/cuda/exact_kernels.h"
#include "renderd/engine/cuda/memory.h"
#include "renderd/engine/cuda/trace_types.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/transfer.h"

namespace diaphane::render::cuda {

/// The voxels in a 3D texture of the device, and the data that the host needs to prepare scenes.
class CudaVolume : public DeviceVolume {
 public:
  /// Loads a volume onto the current device of the calling thread. Fails with kInvalid if size and
  /// voxels do not match, and with kOutOfMemory, which leaves nothing allocated.
  static Result<std::shared_ptr<const CudaVolume>> load(const volume::Volume& volume);
  ~CudaVolume() override;
  CudaVolume(const CudaVolume&) = delete;
  CudaVolume& operator=(const CudaVolume&) = delete;

  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override {
    return 2 * header_.voxel_count() + ranges_.bytes() + labels_.bytes() + label_sets_.bytes() +
           exact_->ranges.bytes() + exact_->levels.bytes() + exact_->first_of.bytes() +
           exact_->missing.bytes() + exact_->nodes.bytes();
  }
  /// Returns the grid without the arrays that only the device needs.
  const ValueGrid& grid() const { return grid_; }
  /// Returns the transfer functions baked for this phase of a scan, or null if there is one phase.
  TransferCache* baked() const { return header_.phase_count() > 1 ? &baked_ : nullptr; }
  /// Returns the transfer functions baked for this volume as the second scan of a session.
  TransferCache* always_baked() const { return &baked_; }
  const ValueRange* ranges() const { return ranges_.data(); }
  TextureVolume view() const;
  /// These return LabelsView::voxels and LabelGrid::set_of_cell, or null if there are no labels.
  const std::uint8_t* labels() const { return labels_.data(); }
  const std::uint32_t* label_sets() const { return label_sets_.data(); }
  /// Returns the CUDA index of the device that holds the volume.
  int device() const { return device_; }

  /// Prepares the exact walk: marks the bricks that a transfer function leaves empty in `skips` (8
  /// bytes per brick), and stores the cells of the other bricks in the pool of nodes while there is
  /// room. Waits for the stream, and for other sessions that call this function. Returns the
  /// fraction of empty bricks.
  Result<double> prepare_exact(const std::int32_t* clear_until, std::uint8_t* skips,
                               cudaStream_t stream) const;
  std::size_t brick_count() const;
  /// Returns the size of the skips of a transfer function in bytes.
  std::size_t skip_bytes() const {
    return 8 * static_cast<std::size_t>(BrickArray(grid_.bricks).count);
  }

 private:
  /// Data of the exact walk that all sessions share. Nodes are added when a session needs a brick.
  struct Exact {
    std::mutex mutex;
    DeviceBuffer<ValueRange> ranges;
    DeviceBuffer<std::uint8_t> levels;
    DeviceBuffer<std::int32_t> first_of, missing;
    DeviceBuffer<CellNode> nodes;
    DeviceBuffer<std::uint32_t> counters;  ///< the two of NodePool, and the occupied bricks
    std::uint32_t capacity = 0;
    bool made = false;
  };
  Result<void> make_exact(cudaStream_t stream) const;

  explicit CudaVolume(const volume::Header& header) : header_(header) {}
  Result<void> upload(const std::int16_t* voxels, cudaStream_t stream);
  Result<void> find_ranges(cudaStream_t stream);
  Result<void> upload_labels(const volume::LabelSet& set, cudaStream_t stream);

  volume::Header header_;
  int device_ = 0;
  ValueGrid grid_;
  mutable TransferCache baked_;
  DeviceBuffer<ValueRange> ranges_;
  DeviceBuffer<std::uint8_t> labels_;
  DeviceBuffer<std::uint32_t> label_sets_;
  cudaArray_t array_ = nullptr;
  cudaTextureObject_t texture_ = 0;
  std::unique_ptr<Exact> exact_ = std::make_unique<Exact>();
};

}  // namespace diaphane::render::cuda
