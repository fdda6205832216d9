#pragma once

#include <cuda_runtime_api.h>

#include <memory>

#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_trace_types.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/grid.h"

namespace diaphane::render::cuda {

/// Voxels in a 3D texture of the device; what the host needs to prepare scenes beside it.
class CudaVolume : public DeviceVolume {
 public:
  /// kInvalid when size and voxels do not fit together; kOutOfMemory leaves nothing behind.
  static Result<std::shared_ptr<const CudaVolume>> load(const volume::Volume& volume);
  ~CudaVolume() override;
  CudaVolume(const CudaVolume&) = delete;
  CudaVolume& operator=(const CudaVolume&) = delete;

  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override {
    return 2 * header_.voxel_count() + ranges_.bytes();
  }
  /// Without its ranges, which are on the device.
  const ValueGrid& grid() const { return grid_; }
  const ValueRange* ranges() const { return ranges_.data(); }
  TextureVolume view() const;

 private:
  explicit CudaVolume(const volume::Header& header) : header_(header) {}
  Result<void> upload(const std::int16_t* voxels, cudaStream_t stream);
  Result<void> find_ranges(cudaStream_t stream);

  volume::Header header_;
  ValueGrid grid_;
  DeviceBuffer<ValueRange> ranges_;
  cudaArray_t array_ = nullptr;
  cudaTextureObject_t texture_ = 0;
};

}  // namespace diaphane::render::cuda
