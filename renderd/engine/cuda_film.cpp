#include "renderd/engine/cuda_film.h"

#include <limits>
#include <vector>

namespace diaphane::render::cuda {
namespace {

/// Pixels whose radiance is made at a time: 12 bytes each, only while it is made.
constexpr std::uint64_t kRadiancePixels = 1 << 18;

}  // namespace

Result<CudaFilm> CudaFilm::make(Canvas canvas) {
  CudaFilm film;
  film.canvas_ = canvas;
  const std::uint64_t pixels = film.pixels();
  DIAPHANE_TRY(ensure(film.sum_, 3 * pixels));
  DIAPHANE_TRY(ensure(film.difference_, 3 * pixels));
  DIAPHANE_TRY(ensure(film.state_, pixels));
  DIAPHANE_TRY(ensure(film.dropped_, 1));
  film.rows_ = RowCounts(canvas.height);
  return film;
}

std::uint32_t CudaFilm::tile_count() const {
  return ((canvas_.width + kTileSize - 1) / kTileSize) *
         ((canvas_.height + kTileSize - 1) / kTileSize);
}

std::uint64_t CudaFilm::device_bytes() const {
  return sum_.bytes() + difference_.bytes() + state_.bytes() + dropped_.bytes() +
         (guides_.data() == nullptr ? 0 : guides_.bytes()) + by_stripe_.bytes() + counts_.bytes() +
         tiles_.bytes() + display_.bytes();
}

Result<void> CudaFilm::keep_guides(bool wanted) {
  if (!wanted) guides_ = {};
  return wanted ? ensure(guides_, pixels()) : Result<void>{};
}

Result<void> CudaFilm::clear(cudaStream_t stream) {
  rows_ = RowCounts(canvas_.height);
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(sum_.data(), 0, sum_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(difference_.data(), 0, difference_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(state_.data(), 0, state_.bytes(), stream));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(dropped_.data(), 0, dropped_.bytes(), stream));
  if (guides_.data() != nullptr) {
    DIAPHANE_CUDA_TRY(cudaMemsetAsync(guides_.data(), 0, guides_.bytes(), stream));
  }
  return {};
}

Result<FilmPicture> CudaFilm::picture(cudaStream_t stream) const {
  FilmPicture picture{{sum_.data(), difference_.data(), state_.data()},
                      canvas_.width,
                      canvas_.height,
                      {rows_.least(), nullptr}};
  if (rows_.flat()) return picture;
  std::vector<std::uint64_t> counts;
  for (std::uint32_t row = 0; row < canvas_.height; row += kStripeRows) {
    counts.push_back(rows_.of(row));
  }
  DIAPHANE_TRY(ensure(by_stripe_, counts.size()));
  DIAPHANE_TRY(upload(by_stripe_, counts.data(), counts.size(), stream));
  picture.samples.by_stripe = by_stripe_.data();
  return picture;
}

Result<std::uint64_t> CudaFilm::dropped(cudaStream_t stream) const {
  std::uint64_t count = 0;
  DIAPHANE_TRY(download(&count, dropped_, 1, stream));
  return count;
}

Result<float> CudaFilm::white(const FilmPicture& film, cudaStream_t stream) const {
  DIAPHANE_TRY(ensure(counts_, kWhiteCounts));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(counts_.data(), 0, counts_.bytes(), stream));
  DIAPHANE_CUDA_TRY(white_histogram(film, counts_.data(), stream));
  WhiteHistogram histogram;
  DIAPHANE_TRY(download(histogram.counts, counts_, kWhiteCounts, stream));
  return white_from_histogram(histogram);
}

Result<double> CudaFilm::error(cudaStream_t stream) const {
  if (samples() < 2) return std::numeric_limits<double>::infinity();
  DIAPHANE_TRY(ensure(tiles_, tile_count()));
  const auto film = picture(stream);
  if (!film) return tl::unexpected(film.error());
  const auto white_value = white(*film, stream);
  if (!white_value) return tl::unexpected(white_value.error());
  DIAPHANE_CUDA_TRY(tile_errors(*film, 1.0f / *white_value, tiles_.data(), stream));
  std::vector<TileError> tiles(tile_count());
  DIAPHANE_TRY(download(tiles.data(), tiles_, tiles.size(), stream));
  return total_error(tiles, samples());
}

Result<void> CudaFilm::display(float scale, std::uint8_t* rgb, cudaStream_t stream) const {
  DIAPHANE_TRY(ensure(display_, 3 * pixels()));
  const auto film = picture(stream);
  if (!film) return tl::unexpected(film.error());
  DIAPHANE_CUDA_TRY(display_film(*film, scale, display_.data(), stream));
  return download(rgb, display_, 3 * pixels(), stream);
}

Result<void> CudaFilm::radiance(float* rgb, cudaStream_t stream) const {
  auto part = DeviceBuffer<float>::of(3 * smaller(pixels(), kRadiancePixels));
  if (!part) return tl::unexpected(part.error());
  const auto film = picture(stream);
  if (!film) return tl::unexpected(film.error());
  for (std::uint64_t first = 0; first < pixels(); first += kRadiancePixels) {
    const std::uint64_t count = smaller(pixels() - first, kRadiancePixels);
    DIAPHANE_CUDA_TRY(mean_of_film(*film, first, count, part->data(), stream));
    DIAPHANE_TRY(download(rgb + 3 * first, *part, 3 * count, stream));
  }
  return {};
}

Result<DenoiseWork> CudaFilm::denoise_work(float voxel, float fade, cudaStream_t stream) const {
  const auto film = picture(stream);
  if (!film) return tl::unexpected(film.error());
  const auto white_value = white(*film, stream);
  if (!white_value) return tl::unexpected(white_value.error());
  return DenoiseWork{*film, guides_.data(), *white_value, voxel, fade, {}};
}

Result<void> CudaFilm::display_denoised(CudaDenoiser& denoiser, float voxel, float fade,
                                        float scale, std::uint8_t* rgb, cudaStream_t stream) const {
  const auto work = denoise_work(voxel, fade, stream);
  if (!work) return tl::unexpected(work.error());
  return denoiser.run(*work, scale, rgb, nullptr, stream);
}

Result<void> CudaFilm::radiance_denoised(CudaDenoiser& denoiser, float voxel, float fade,
                                         float* rgb, cudaStream_t stream) const {
  const auto work = denoise_work(voxel, fade, stream);
  if (!work) return tl::unexpected(work.error());
  return denoiser.run(*work, 1.0f, nullptr, rgb, stream);
}

Result<void> CudaFilm::contents(std::uint8_t* met, cudaStream_t stream) const {
  std::vector<std::uint32_t> state(pixels());
  DIAPHANE_TRY(download(state.data(), state_, state.size(), stream));
  for (std::uint64_t i = 0; i < state.size(); ++i) met[i] = (state[i] & kMetMatter) != 0 ? 1 : 0;
  return {};
}

}  // namespace diaphane::render::cuda
