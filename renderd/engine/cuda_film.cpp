#include "renderd/engine/cuda_film.h"

#include <limits>
#include <vector>

namespace diaphane::render::cuda {
namespace {

template <typename T>
Result<void> allocate(DeviceBuffer<T>& buffer, std::uint64_t count) {
  auto made = DeviceBuffer<T>::of(count);
  if (!made) return tl::unexpected(made.error());
  buffer = std::move(*made);
  return {};
}

}  // namespace

Result<CudaFilm> CudaFilm::make(Canvas canvas) {
  CudaFilm film;
  film.canvas_ = canvas;
  const std::uint64_t pixels = film.pixels();
  DIAPHANE_TRY(allocate(film.sum_, 3 * pixels));
  DIAPHANE_TRY(allocate(film.difference_, 3 * pixels));
  DIAPHANE_TRY(allocate(film.state_, pixels));
  DIAPHANE_TRY(allocate(film.batch_, pixels));
  DIAPHANE_TRY(allocate(film.dropped_, 1));
  DIAPHANE_TRY(allocate(film.counts_, kWhiteBins));
  DIAPHANE_TRY(allocate(film.tiles_, film.tile_count()));
  DIAPHANE_TRY(allocate(film.picture_, 3 * pixels));
  return film;
}

std::uint32_t CudaFilm::tile_count() const {
  return ((canvas_.width + kTileSize - 1) / kTileSize) *
         ((canvas_.height + kTileSize - 1) / kTileSize);
}

Result<void> CudaFilm::clear(cudaStream_t stream) {
  samples_ = 0;
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(sum_.data(), 0, sum_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(difference_.data(), 0, difference_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(state_.data(), 0, state_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(dropped_.data(), 0, dropped_.bytes(), stream));
  return {};
}

Result<void> CudaFilm::fold(std::uint32_t samples, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(fold_batch({sum_.data(), difference_.data(), state_.data()}, batch_.data(),
                               pixels(), dropped_.data(), stream));
  samples_ += samples;
  return {};
}

Result<std::uint64_t> CudaFilm::dropped(cudaStream_t stream) const {
  std::uint64_t count = 0;
  DIAPHANE_TRY(download(&count, dropped_, 1, stream));
  return count;
}

Result<double> CudaFilm::error(cudaStream_t stream) const {
  if (samples_ < 2) return std::numeric_limits<double>::infinity();
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(counts_.data(), 0, counts_.bytes(), stream));
  DIAPHANE_CUDA_TRY(white_histogram(view(), pixels(), samples_, counts_.data(), stream));
  WhiteHistogram histogram;
  DIAPHANE_TRY(download(histogram.counts, counts_, kWhiteBins, stream));
  const float white = white_from_histogram(histogram);
  DIAPHANE_CUDA_TRY(tile_errors(view(), canvas_.width, canvas_.height, samples_, 1.0f / white,
                                tiles_.data(), stream));
  std::vector<TileError> tiles(tile_count());
  DIAPHANE_TRY(download(tiles.data(), tiles_, tiles.size(), stream));
  return total_error(tiles, samples_);
}

Result<void> CudaFilm::display(float scale, std::uint8_t* rgb, cudaStream_t stream) const {
  DIAPHANE_CUDA_TRY(display_film(view(), pixels(), samples_, scale, picture_.data(), stream));
  return download(rgb, picture_, 3 * pixels(), stream);
}

Result<void> CudaFilm::radiance(float* rgb, cudaStream_t stream) const {
  // Seldom asked for: its memory exists only while it is made.
  auto made = DeviceBuffer<float>::of(3 * pixels());
  if (!made) return tl::unexpected(made.error());
  DIAPHANE_CUDA_TRY(mean_of_film(view(), pixels(), samples_, made->data(), stream));
  return download(rgb, *made, 3 * pixels(), stream);
}

Result<void> CudaFilm::contents(std::uint8_t* met, cudaStream_t stream) const {
  std::vector<std::uint32_t> state(pixels());
  DIAPHANE_TRY(download(state.data(), state_, state.size(), stream));
  for (std::uint64_t i = 0; i < state.size(); ++i) met[i] = (state[i] & kMetMatter) != 0 ? 1 : 0;
  return {};
}

}  // namespace diaphane::render::cuda
