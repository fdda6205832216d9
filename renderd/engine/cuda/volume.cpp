#include "renderd/engine/cuda/volume.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/try.h"
#include "renderd/engine/cuda/acceleration_kernels.h"

namespace diaphane::render::cuda {

Result<std::shared_ptr<const CudaVolume>> CudaVolume::load(const volume::Volume& volume) {
  DIAPHANE_TRY(check_volume(volume));
  std::shared_ptr<CudaVolume> loaded(new CudaVolume(volume.header));
  DIAPHANE_CUDA_TRY(cudaGetDevice(&loaded->device_));
  auto stream = Stream::make();
  DIAPHANE_TRY(stream);
  DIAPHANE_TRY(loaded->upload(volume.voxels.data(), stream->get()));
  DIAPHANE_TRY(loaded->find_ranges(stream->get()));
  DIAPHANE_TRY(loaded->upload_labels(volume.label_set, stream->get()));
  return loaded;
}

CudaVolume::~CudaVolume() {
  cudaSetDevice(device_);
  if (texture_ != 0) cudaDestroyTextureObject(texture_);
  if (array_ != nullptr) cudaFreeArray(array_);
}

Result<void> CudaVolume::upload(const std::int16_t* voxels, cudaStream_t stream) {
  const auto& size = header_.size;
  const cudaExtent extent{size[0], size[1], size[2]};
  const cudaChannelFormatDesc format{16, 0, 0, 0, cudaChannelFormatKindSigned};
  DIAPHANE_CUDA_TRY(cudaMalloc3DArray(&array_, &format, extent));

  cudaMemcpy3DParms copy{};
  // The copy only reads. CUDA has one structure for both directions, whose pointer is not const.
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
  DIAPHANE_TRY(ranges);
  ranges_ = std::move(*ranges);
  auto whole = DeviceBuffer<std::int32_t>::of(2);
  DIAPHANE_TRY(whole);
  std::int32_t low_high[] = {32767, -32768};
  DIAPHANE_TRY(cuda::upload(*whole, low_high, 2, stream));
  DIAPHANE_CUDA_TRY(value_ranges(view(), grid_.cells, ranges_.data(), whole->data(), stream));
  DIAPHANE_TRY(download(low_high, *whole, 2, stream));
  grid_.whole = {static_cast<std::int16_t>(low_high[0]), static_cast<std::int16_t>(low_high[1])};
  grid_.bricks = bricks_of(view().size);
  return {};
}

Result<void> CudaVolume::upload_labels(const volume::LabelSet& set, cudaStream_t stream) {
  if (set.empty()) return {};
  grid_.labels = make_label_grid(set, size_of(header_));
  const std::vector<std::uint8_t>& voxels = set.labels.voxels;
  DIAPHANE_TRY(ensure(labels_, voxels.size()));
  DIAPHANE_TRY(cuda::upload(labels_, voxels.data(), voxels.size(), stream));
  // Only the device needs the label sets of the cells, because the host computes no bounds.
  const std::vector<std::uint32_t> sets = std::exchange(grid_.labels.set_of_cell, {});
  DIAPHANE_TRY(ensure(label_sets_, sets.size()));
  DIAPHANE_TRY(cuda::upload(label_sets_, sets.data(), sets.size(), stream));
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  return {};
}

TextureVolume CudaVolume::view() const {
  const auto& size = header_.size;
  return {texture_,
          {static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]),
           static_cast<std::int32_t>(size[2])},
          exact_->nodes.data(),
          exact_->first_of.data() == nullptr
              ? nullptr
              : exact_->first_of.data() + BrickArray(grid_.bricks).first};
}

std::size_t CudaVolume::brick_count() const {
  const Int3 b = grid_.bricks;
  return static_cast<std::size_t>(b.x) * static_cast<std::size_t>(b.y) *
         static_cast<std::size_t>(b.z);
}

Result<void> CudaVolume::make_exact(cudaStream_t stream) const {
  if (exact_->made) return {};
  const std::size_t bricks = brick_count();
  DIAPHANE_TRY(ensure(exact_->ranges, bricks));
  DIAPHANE_TRY(ensure(exact_->levels, 8 * bricks));
  const auto with_rim = static_cast<std::size_t>(BrickArray(grid_.bricks).count);
  DIAPHANE_TRY(ensure(exact_->first_of, with_rim));
  DIAPHANE_TRY(ensure(exact_->missing, bricks));
  DIAPHANE_TRY(ensure(exact_->counters, 3));
  const std::vector<std::int32_t> none(with_rim, TextureVolume::kNoNodes);
  DIAPHANE_TRY(cuda::upload(exact_->first_of, none.data(), with_rim, stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(exact_->counters.data(), 0, exact_->counters.bytes(), stream));
  DIAPHANE_CUDA_TRY(brick_ranges(view(), grid_.bricks, exact_->ranges.data(), stream));
  // Together with the volume and the small arrays, the nodes take at most three times the volume.
  // If this memory is not available, cells are read from the texture.
  constexpr double kMostOfVolume = 1.6;
  constexpr std::size_t kSlot = 64;
  const auto requested_slots = static_cast<std::size_t>(
      kMostOfVolume * 2 * static_cast<double>(header_.voxel_count()) / (kSlot * sizeof(CellNode)));
  // The index of a node must fit into 31 bits.
  constexpr std::size_t kMostSlots = (std::size_t{1} << 31) / kSlot - 1;
  const std::size_t slots = std::min({requested_slots, bricks, kMostSlots});
  if (slots > 0 && ensure(exact_->nodes, kSlot * slots))
    exact_->capacity = static_cast<std::uint32_t>(slots);
  exact_->made = true;
  return {};
}

Result<double> CudaVolume::prepare_exact(const std::int32_t* clear_until, std::uint8_t* skips,
                                         cudaStream_t stream) const {
  const std::scoped_lock lock(exact_->mutex);
  DIAPHANE_TRY(make_exact(stream));
  const NodePool pool{exact_->nodes.data(), exact_->first_of.data(), exact_->counters.data(),
                      exact_->missing.data(), exact_->capacity};
  std::uint32_t* occupied = exact_->counters.data() + 2;
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(occupied, 0, sizeof(std::uint32_t), stream));
  DIAPHANE_CUDA_TRY(mark_bricks(exact_->ranges.data(), grid_.bricks, clear_until,
                                grid_.whole.minimum, exact_->levels.data(), pool, occupied,
                                stream));
  DIAPHANE_CUDA_TRY(find_skips(exact_->levels.data(), grid_.bricks, skips, stream));
  if (pool.capacity > 0) DIAPHANE_CUDA_TRY(fill_nodes(view(), grid_.bricks, pool, stream));
  std::uint32_t numbers[3] = {};
  DIAPHANE_TRY(download(numbers, exact_->counters, 3, stream));
  return 1.0 - numbers[2] / static_cast<double>(brick_count());
}

}  // namespace diaphane::render::cuda
