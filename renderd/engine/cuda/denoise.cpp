#include "renderd/engine/cuda/denoise.h"

#include "common/try.h"

namespace diaphane::render::cuda {
namespace {

template <typename T>
Result<void> enlarge(DeviceBuffer<T>& buffer, std::uint64_t count) {
  if (buffer.data() != nullptr && buffer.capacity() >= count) return {};
  // The old buffer is freed first, because both may not fit at the same time.
  buffer = {};
  auto made = DeviceBuffer<T>::of(count);
  DIAPHANE_TRY(made);
  buffer = std::move(*made);
  return {};
}

}  // namespace

Result<void> CudaDenoiser::grow(std::uint64_t pixels, std::uint64_t tiles) {
  DIAPHANE_TRY(enlarge(raw_, pixels));
  DIAPHANE_TRY(enlarge(from_, pixels));
  DIAPHANE_TRY(enlarge(to_, pixels));
  DIAPHANE_TRY(enlarge(variance_, pixels));
  DIAPHANE_TRY(enlarge(from_variance_, pixels));
  DIAPHANE_TRY(enlarge(to_variance_, pixels));
  DIAPHANE_TRY(enlarge(slope_, pixels));
  DIAPHANE_TRY(enlarge(steering_, pixels));
  DIAPHANE_TRY(enlarge(gains_, tiles));
  for (std::optional<Event>* event : {&begin_, &end_}) {
    if (*event) continue;
    auto made = Event::make();
    DIAPHANE_TRY(made);
    *event = std::move(*made);
  }
  return {};
}

Result<void> CudaDenoiser::run(DenoiseWork w, float scale, std::uint8_t* rgb, float* radiance,
                               cudaStream_t stream) {
  const std::lock_guard lock(mutex_);
  const auto tiles = [](std::uint32_t length) { return (length + kGainTile - 1) / kGainTile; };
  const std::uint32_t width = w.picture.width, height = w.picture.height;
  DIAPHANE_TRY(grow(std::uint64_t{width} * height, std::uint64_t{tiles(width)} * tiles(height)));
  w.buffers = {raw_.data(),      from_.data(),          to_.data(),
               variance_.data(), from_variance_.data(), to_variance_.data(),
               steering_.data(), slope_.data(),         gains_.data()};
  DIAPHANE_CUDA_TRY(cudaEventRecord(begin_->get(), stream));
  // The picture overwrites buffers that the passes no longer need, so it takes no additional
  // memory.
  static_assert(kDenoisePasses >= 2 && kDenoisePasses % 2 == 0, "the last one writes `from`");
  auto* rgb_here = rgb == nullptr ? nullptr : reinterpret_cast<std::uint8_t*>(variance_.data());
  auto* radiance_here = radiance == nullptr ? nullptr : reinterpret_cast<float*>(to_.data());
  DIAPHANE_CUDA_TRY(denoise(w, scale, rgb_here, radiance_here, stream));
  DIAPHANE_CUDA_TRY(cudaEventRecord(end_->get(), stream));
  const std::size_t numbers = std::size_t{3} * width * height;
  if (rgb != nullptr) DIAPHANE_TRY(read_back(rgb, rgb_here, numbers, stream));
  if (radiance != nullptr) {
    DIAPHANE_CUDA_TRY(cudaMemcpyAsync(radiance, radiance_here, numbers * sizeof(float),
                                      cudaMemcpyDeviceToHost, stream));
  }
  // The next session may use the memory on another stream, which would not wait for this one.
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  DIAPHANE_CUDA_TRY(cudaEventElapsedTime(&milliseconds_, begin_->get(), end_->get()));
  return {};
}

double CudaDenoiser::last_milliseconds() const {
  const std::lock_guard lock(mutex_);
  return static_cast<double>(milliseconds_);
}

}  // namespace diaphane::render::cuda
