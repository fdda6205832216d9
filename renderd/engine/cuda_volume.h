#pragma once

#include <cuda_runtime_api.h>

#include <memory>
#include <mutex>

#include "renderd/engine/cuda_exact_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_trace_types.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/grid.h"

namespace diaphane::render::cuda {

/// Voxels in a 3D texture of the device; what the host needs to prepare scenes beside it.
class CudaVolume : public DeviceVolume {
 public:
  /// kInvalid when size and voxels do not fit together; kOutOfMemory leaves nothing behind.
  /// Onto the calling thread's current device.
  static Result<std::shared_ptr<const CudaVolume>> load(const volume::Volume& volume);
  ~CudaVolume() override;
  CudaVolume(const CudaVolume&) = delete;
  CudaVolume& operator=(const CudaVolume&) = delete;

  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override {
    return 2 * header_.voxel_count() + ranges_.bytes() + exact_->ranges.bytes() +
           exact_->levels.bytes() + exact_->first_of.bytes() + exact_->missing.bytes() +
           exact_->nodes.bytes();
  }
  /// Without its ranges, which are on the device.
  const ValueGrid& grid() const { return grid_; }
  const ValueRange* ranges() const { return ranges_.data(); }
  TextureVolume view() const;
  /// CUDA's number of the device that it is on.
  int device() const { return device_; }

  /// For the exact walk: marks the bricks that a transfer function leaves empty in `skips` (8 bytes
  /// a brick), and puts the cells of the others into the pool of nodes, as far as that goes. Waits
  /// for the stream, and for another session that is at it. The share of bricks that are empty.
  Result<double> prepare_exact(const std::int32_t* clear_until, std::uint8_t* skips,
                               cudaStream_t stream) const;
  std::size_t brick_count() const;
  /// Bytes of the skips of a transfer function.
  std::size_t skip_bytes() const {
    return 8 * static_cast<std::size_t>(BrickArray(grid_.bricks).count);
  }

 private:
  /// Shared by the sessions, and filled by what they look at.
  struct Exact {
    std::mutex mutex;
    DeviceBuffer<ValueRange> ranges;
    DeviceBuffer<std::uint8_t> levels;
    DeviceBuffer<std::int32_t> first_of, missing;
    DeviceBuffer<CellNode> nodes;
    DeviceBuffer<std::uint32_t> counters;  ///< NodePool's two, and the occupied bricks
    std::uint32_t capacity = 0;
    bool made = false;
  };
  Result<void> make_exact(cudaStream_t stream) const;

  explicit CudaVolume(const volume::Header& header) : header_(header) {}
  Result<void> upload(const std::int16_t* voxels, cudaStream_t stream);
  Result<void> find_ranges(cudaStream_t stream);

  volume::Header header_;
  int device_ = 0;
  ValueGrid grid_;
  DeviceBuffer<ValueRange> ranges_;
  cudaArray_t array_ = nullptr;
  cudaTextureObject_t texture_ = 0;
  std::unique_ptr<Exact> exact_ = std::make_unique<Exact>();
};

}  // namespace diaphane::render::cuda
