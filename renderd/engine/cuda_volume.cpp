#include "renderd/engine/cuda_volume.h"

#include "renderd/engine/cuda_memory.h"

namespace diaphane::render::cuda {

Result<std::shared_ptr<const CudaVolume>> CudaVolume::load(const volume::Volume& volume) {
  DIAPHANE_TRY(check_volume(volume));
  std::shared_ptr<CudaVolume> loaded(new CudaVolume(volume.header));
  DIAPHANE_TRY(loaded->upload(volume.voxels.data()));
  const auto& size = volume.header.size;
  loaded->grid_ = make_value_grid(
      volume.voxels, Int3{static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]),
                          static_cast<std::int32_t>(size[2])});
  return loaded;
}

CudaVolume::~CudaVolume() {
  if (texture_ != 0) cudaDestroyTextureObject(texture_);
  if (array_ != nullptr) cudaFreeArray(array_);
}

Result<void> CudaVolume::upload(const std::int16_t* voxels) {
  const auto& size = header_.size;
  const cudaExtent extent{size[0], size[1], size[2]};
  const cudaChannelFormatDesc format{16, 0, 0, 0, cudaChannelFormatKindSigned};
  DIAPHANE_CUDA_TRY(cudaMalloc3DArray(&array_, &format, extent));

  auto stream = Stream::make();
  if (!stream) return tl::unexpected(stream.error());
  cudaMemcpy3DParms copy{};
  // The copy only reads: CUDA's one structure for both directions has no pointer to const.
  copy.srcPtr = {const_cast<std::int16_t*>(voxels), 2 * std::size_t{size[0]}, size[0], size[1]};
  copy.dstArray = array_;
  copy.extent = extent;
  copy.kind = cudaMemcpyHostToDevice;
  DIAPHANE_CUDA_TRY(cudaMemcpy3DAsync(&copy, stream->get()));
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream->get()));

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

TextureVolume CudaVolume::view() const {
  const auto& size = header_.size;
  return {texture_,
          {static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]),
           static_cast<std::int32_t>(size[2])}};
}

}  // namespace diaphane::render::cuda
