#include "renderd/engine/cuda_volume.h"

#include "renderd/engine/cuda_acceleration_kernels.h"

namespace diaphane::render::cuda {

Result<std::shared_ptr<const CudaVolume>> CudaVolume::load(const volume::Volume& volume) {
  DIAPHANE_TRY(check_volume(volume));
  std::shared_ptr<CudaVolume> loaded(new CudaVolume(volume.header));
  auto stream = Stream::make();
  if (!stream) return tl::unexpected(stream.error());
  DIAPHANE_TRY(loaded->upload(volume.voxels.data(), stream->get()));
  DIAPHANE_TRY(loaded->find_ranges(stream->get()));
  return loaded;
}

CudaVolume::~CudaVolume() {
  if (texture_ != 0) cudaDestroyTextureObject(texture_);
  if (array_ != nullptr) cudaFreeArray(array_);
}

Result<void> CudaVolume::upload(const std::int16_t* voxels, cudaStream_t stream) {
  const auto& size = header_.size;
  const cudaExtent extent{size[0], size[1], size[2]};
  const cudaChannelFormatDesc format{16, 0, 0, 0, cudaChannelFormatKindSigned};
  DIAPHANE_CUDA_TRY(cudaMalloc3DArray(&array_, &format, extent));

  cudaMemcpy3DParms copy{};
  // The copy only reads: CUDA's one structure for both directions has no pointer to const.
  copy.srcPtr = {const_cast<std::int16_t*>(voxels), 2 * std::size_t{size[0]}, size[0], size[1]};
  copy.dstArray = array_;
  copy.extent = extent;
  copy.kind = cudaMemcpyHostToDevice;
  DIAPHANE_CUDA_TRY(cudaMemcpy3DAsync(&copy, stream));
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));

  cudaResourceDesc resource{};
  resource.resType = cudaResourceTypeArray;
  resource.res.array.array = array_;
  cudaTextureDesc sampling{};
  for (auto& mode : sampling.addressMode) mode = cudaAddressModeClamp;
  sampling.filterMode = cudaFilterModePoint;
  sampling.readMode = cudaReadModeElementType;
  DIAPHANE_CUDA_TRY(cudaCreateTextureObject(&texture_, &resource, &sampling, nullptr));
  return {};
}

Result<void> CudaVolume::find_ranges(cudaStream_t stream) {
  const auto along = [](std::uint32_t n) {
    return static_cast<std::int32_t>((n + kCellSize - 1) >> kCellShift);
  };
  const auto& size = header_.size;
  grid_.cells = {along(size[0]), along(size[1]), along(size[2])};
  auto ranges = DeviceBuffer<ValueRange>::of(static_cast<std::size_t>(grid_.cells.x) *
                                             static_cast<std::size_t>(grid_.cells.y) *
                                             static_cast<std::size_t>(grid_.cells.z));
  if (!ranges) return tl::unexpected(ranges.error());
  ranges_ = std::move(*ranges);
  auto whole = DeviceBuffer<std::int32_t>::of(2);
  if (!whole) return tl::unexpected(whole.error());
  std::int32_t low_high[] = {32767, -32768};
  DIAPHANE_TRY(cuda::upload(*whole, low_high, 2, stream));
  DIAPHANE_CUDA_TRY(value_ranges(view(), grid_.cells, ranges_.data(), whole->data(), stream));
  DIAPHANE_TRY(download(low_high, *whole, 2, stream));
  grid_.whole = {static_cast<std::int16_t>(low_high[0]), static_cast<std::int16_t>(low_high[1])};
  return {};
}

TextureVolume CudaVolume::view() const {
  const auto& size = header_.size;
  return {texture_,
          {static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]),
           static_cast<std::int32_t>(size[2])}};
}

}  // namespace diaphane::render::cuda
