#include "renderd/engine/cuda/film.h"

#include <atomic>
#include <limits>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "common/try.h"

namespace diaphane::render::cuda {
namespace {

/// Number of pixels whose radiance is computed at once. Each takes 12 bytes of temporary device
/// memory.
constexpr std::uint64_t kRadiancePixels = 1 << 18;

/// Lets the current device, `here`, read the memory of device `there` directly if possible.
/// Otherwise CUDA copies through the host.
void allow_access(int here, int there) {
  static std::mutex mutex;
  static std::set<std::pair<int, int>> asked;
  const std::scoped_lock lock(mutex);
  if (!asked.emplace(here, there).second) return;
  int can = 0;
  if (cudaDeviceCanAccessPeer(&can, here, there) != cudaSuccess || can == 0 ||
      cudaDeviceEnablePeerAccess(there, 0) != cudaSuccess) {
    (void)cudaGetLastError();
  }
}

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
  std::uint64_t handed = 0;
  for (const auto& part : handed_) {
    if (part && part->pixels.data() != nullptr) handed += part->pixels.bytes();
  }
  return handed + sum_.bytes() + difference_.bytes() + state_.bytes() + dropped_.bytes() +
         (guides_.data() == nullptr ? 0 : guides_.bytes()) + by_stripe_.bytes() + counts_.bytes() +
         tiles_.bytes() + display_.bytes() + (packed_.data() == nullptr ? 0 : packed_.bytes());
}

bool CudaFilm::holds(Canvas canvas) const {
  return std::uint64_t{canvas.width} * canvas.height <= state_.capacity();
}

void CudaFilm::reshape(Canvas canvas) {
  canvas_ = canvas;
  rows_ = RowCounts(canvas.height);
}

Result<void> CudaFilm::keep_guides(bool enabled) {
  guided_ = false;
  if (enabled) {
    if (guides_.data() == nullptr) display_ = {};  // guides and display share the memory
    DIAPHANE_TRY(ensure(guides_, pixels()));
  }
  guided_ = enabled;
  return {};
}

Result<void> CudaFilm::clear(cudaStream_t stream) {
  first_row_ = 0;
  rows_ = RowCounts(canvas_.height);
  taken_ = 0;
  merged_.clear();
  metering_.reset();
  DIAPHANE_TRY(zero(sum_, 3 * pixels(), stream));
  DIAPHANE_TRY(zero(difference_, 3 * pixels(), stream));
  DIAPHANE_TRY(zero(state_, pixels(), stream));
  DIAPHANE_TRY(zero(dropped_, 1, stream));
  return guided_ ? zero(guides_, pixels(), stream) : Result<void>{};
}

std::uint64_t CudaFilm::samples_of(std::uint32_t row) const {
  const std::uint64_t merged = merged_.empty() ? 0 : merged_[row / kShareRows];
  const bool own = row >= first_row_ && row < last_row();
  return merged + (own ? rows_.of(row - first_row_) - taken_ : 0);
}

std::uint64_t CudaFilm::samples() const {
  if (merged_.empty() && rows_.rows() == canvas_.height) return rows_.least() - taken_;
  std::uint64_t least = samples_of(0);
  for (std::uint32_t row = 0; row < canvas_.height; row += kStripeRows) {
    least = min(least, samples_of(row));
  }
  return least;
}

void CudaFilm::count_as_merged(std::uint32_t first_row, std::uint32_t last_row,
                               std::uint64_t samples) {
  merged_.resize((canvas_.height + kShareRows - 1) / kShareRows, 0);
  for (std::uint32_t row = first_row; row < last_row; row += kShareRows) {
    merged_[row / kShareRows] += samples;
  }
}

Result<void> CudaFilm::set_share(const Share& share) {
  const std::uint32_t last = min(share.last_row, canvas_.height);
  if (!is_band(share.first_row, last, canvas_.height)) {
    return fail(ErrorCode::kInvalid, "a share must begin and end at a multiple of the row unit",
                "share");
  }
  if (!settled())
    return fail(ErrorCode::kConflict, "the second sample of a pair has not been rendered yet");
  if (rows_.least() > taken_) {
    count_as_merged(first_row_, last_row(), rows_.least() - taken_);
  }
  first_row_ = share.first_row;
  rows_ = RowCounts(last - share.first_row);
  taken_ = 0;
  return {};
}

bool CudaFilm::describe(FilmPart& out) const {
  if (!settled() || rows_.least() == taken_) return false;
  out.width = canvas_.width;
  out.first_row = first_row_;
  out.rows = rows_.rows();
  out.samples = rows_.least() - taken_;
  return true;
}

Result<void> CudaFilm::pack(const FilmPart& part, PackedPixel* to, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(pack_film({sum_.data(), difference_.data(), state_.data()},
                              std::uint64_t{part.width} * part.first_row,
                              std::uint64_t{part.width} * part.rows, part.samples, to, stream));
  return {};
}

Result<bool> CudaFilm::take(FilmPart& out, cudaStream_t stream) {
  if (!describe(out)) return false;
  const std::size_t count = std::size_t{out.width} * out.rows;
  DIAPHANE_TRY(ensure(packed_, count));
  out.on_device = nullptr;
  out.pixels.resize(count);
  DIAPHANE_TRY(pack(out, packed_.data(), stream));
  DIAPHANE_TRY(read_back(reinterpret_cast<std::uint8_t*>(out.pixels.data()),
                         reinterpret_cast<const std::uint8_t*>(packed_.data()),
                         count * sizeof(PackedPixel), stream));
  out.guides.resize(brings_guides(out) ? count : 0);
  if (!out.guides.empty()) {
    const PackedGuides* from = guides_.data() + std::uint64_t{out.width} * out.first_row;
    DIAPHANE_TRY(read_back(reinterpret_cast<std::uint8_t*>(out.guides.data()),
                           reinterpret_cast<const std::uint8_t*>(from),
                           count * sizeof(PackedGuides), stream));
  }
  taken_ = rows_.least();
  metering_.reset();
  return true;
}

Result<bool> CudaFilm::take_here(FilmPart& out, cudaStream_t stream) {
  if (!describe(out)) return false;
  const std::size_t count = std::size_t{out.width} * out.rows;
  // Two parts alternate: while the previous part is still being merged, the one before it is free.
  auto part = handed_[0] && handed_[0].use_count() == 1 ? handed_[0] : handed_[1];
  if (!part || part.use_count() > 2) part = std::make_shared<PackedPart>();
  std::atomic_thread_fence(std::memory_order_acquire);
  DIAPHANE_CUDA_TRY(cudaGetDevice(&part->device));
  DIAPHANE_TRY(ensure(part->pixels, count));
  DIAPHANE_TRY(pack(out, part->pixels.data(), stream));
  part->guided = brings_guides(out);
  if (part->guided) {
    DIAPHANE_TRY(ensure(part->guides, count));
    DIAPHANE_CUDA_TRY(cudaMemcpyAsync(
        part->guides.data(), guides_.data() + std::uint64_t{out.width} * out.first_row,
        count * sizeof(PackedGuides), cudaMemcpyDeviceToDevice, stream));
  }
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  if (part != handed_[0]) handed_[1] = part;
  std::swap(handed_[0], handed_[1]);
  out.pixels.clear();
  out.guides.clear();
  out.on_device = std::move(part);
  taken_ = rows_.least();
  metering_.reset();
  return true;
}

Result<void> CudaFilm::merge_guides(const FilmPart& part, const PackedPart* packed, int here,
                                    cudaStream_t stream) {
  PackedGuides* to = guides_.data() + std::uint64_t{part.width} * part.first_row;
  const std::size_t bytes = std::size_t{part.width} * part.rows * sizeof(PackedGuides);
  if (packed != nullptr && packed->guided) {
    DIAPHANE_CUDA_TRY(
        cudaMemcpyPeerAsync(to, here, packed->guides.data(), packed->device, bytes, stream));
  } else if (packed == nullptr && !part.guides.empty()) {
    DIAPHANE_CUDA_TRY(
        cudaMemcpyAsync(to, part.guides.data(), bytes, cudaMemcpyHostToDevice, stream));
  }
  return {};
}

Result<void> CudaFilm::merge(const FilmPart& part, cudaStream_t stream) {
  const auto* packed = dynamic_cast<const PackedPart*>(part.on_device.get());
  const std::size_t count = std::size_t{part.width} * part.rows;
  if (!fits(part, canvas_) || (part.on_device && packed == nullptr) ||
      (packed != nullptr && packed->pixels.capacity() < count)) {
    return fail(ErrorCode::kInvalid, "this part belongs to a different picture", "part");
  }
  int here = 0;
  DIAPHANE_CUDA_TRY(cudaGetDevice(&here));
  const PackedPixel* from = packed_.data();
  if (packed != nullptr && packed->device == here) {
    from = packed->pixels.data();
  } else {
    DIAPHANE_TRY(ensure(packed_, count));
    from = packed_.data();
    if (packed != nullptr) {
      allow_access(here, packed->device);
      DIAPHANE_CUDA_TRY(cudaMemcpyPeerAsync(packed_.data(), here, packed->pixels.data(),
                                            packed->device, count * sizeof(PackedPixel), stream));
    } else {
      DIAPHANE_TRY(upload(packed_, part.pixels.data(), count, stream));
    }
  }
  DIAPHANE_CUDA_TRY(merge_packed(from, std::uint64_t{canvas_.width} * part.first_row, count,
                                 part.samples, {sum_.data(), difference_.data(), state_.data()},
                                 stream));
  if (guided_) DIAPHANE_TRY(merge_guides(part, packed, here, stream));
  // The next part uses the same memory.
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  count_as_merged(part.first_row, part.first_row + part.rows, part.samples);
  metering_.reset();
  return {};
}

Result<FilmPicture> CudaFilm::picture(cudaStream_t stream) const {
  FilmPicture picture{{sum_.data(), difference_.data(), state_.data()},
                      canvas_.width,
                      canvas_.height,
                      {samples(), nullptr}};
  const bool whole = merged_.empty() && rows_.rows() == canvas_.height;
  if (whole && rows_.flat()) return picture;
  std::vector<std::uint64_t> counts;
  bool differ = false;
  for (std::uint32_t row = 0; row < canvas_.height; row += kStripeRows) {
    counts.push_back(samples_of(row));
    differ |= counts.back() != counts.front();
  }
  if (!differ) return picture;
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

Result<Metering> CudaFilm::metering(const FilmPicture& film, cudaStream_t stream) const {
  if (metering_) return *metering_;
  DIAPHANE_TRY(ensure(counts_, kWhiteCounts));
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(counts_.data(), 0, counts_.bytes(), stream));
  DIAPHANE_CUDA_TRY(white_histogram(film, counts_.data(), stream));
  WhiteHistogram histogram;
  DIAPHANE_TRY(download(histogram.counts, counts_, kWhiteCounts, stream));
  metering_ = metering_of(histogram);
  return *metering_;
}

Result<CudaFilm::Measured> CudaFilm::measure(bool with_mean, cudaStream_t stream) const {
  Measured measured{std::numeric_limits<double>::infinity(), 0};
  if (samples() < (with_mean ? 1 : 2)) return measured;
  DIAPHANE_TRY(ensure(tiles_, tile_count()));
  const auto film = picture(stream);
  DIAPHANE_TRY(film);
  const auto metered = metering(*film, stream);
  DIAPHANE_TRY(metered);
  measured.mean = metered->mean;
  if (samples() < 2) return measured;
  DIAPHANE_CUDA_TRY(tile_errors(*film, 1.0f / metered->white, curve_, tiles_.data(), stream));
  std::vector<TileError> tiles(tile_count());
  DIAPHANE_TRY(download(tiles.data(), tiles_, tiles.size(), stream));
  measured.error = total_error(tiles, samples());
  return measured;
}

Result<void> CudaFilm::display(float scale, std::uint8_t* rgb, cudaStream_t stream) const {
  static_assert(sizeof(PackedGuides) >= 3);
  const bool beside = guided_ || guides_.data() == nullptr || guides_.capacity() < pixels();
  if (beside) DIAPHANE_TRY(ensure(display_, 3 * pixels()));
  auto* picture_here = beside ? display_.data() : reinterpret_cast<std::uint8_t*>(guides_.data());
  const auto film = picture(stream);
  DIAPHANE_TRY(film);
  DIAPHANE_CUDA_TRY(display_film(*film, scale, curve_, picture_here, stream));
  return read_back(rgb, picture_here, 3 * pixels(), stream);
}

Result<void> CudaFilm::radiance(float* rgb, cudaStream_t stream) const {
  auto part = DeviceBuffer<float>::of(3 * min(pixels(), kRadiancePixels));
  DIAPHANE_TRY(part);
  const auto film = picture(stream);
  DIAPHANE_TRY(film);
  for (std::uint64_t first = 0; first < pixels(); first += kRadiancePixels) {
    const std::uint64_t count = min(pixels() - first, kRadiancePixels);
    DIAPHANE_CUDA_TRY(mean_of_film(*film, first, count, part->data(), stream));
    DIAPHANE_TRY(download(rgb + 3 * first, *part, 3 * count, stream));
  }
  return {};
}

Result<DenoiseWork> CudaFilm::denoise_work(float voxel, float fade, cudaStream_t stream) const {
  const auto film = picture(stream);
  DIAPHANE_TRY(film);
  const auto metered = metering(*film, stream);
  DIAPHANE_TRY(metered);
  return DenoiseWork{*film, guides_.data(), metered->white, voxel, fade, curve_, {}};
}

Result<void> CudaFilm::display_denoised(CudaDenoiser& denoiser, float voxel, float fade,
                                        float scale, std::uint8_t* rgb, cudaStream_t stream) const {
  const auto work = denoise_work(voxel, fade, stream);
  DIAPHANE_TRY(work);
  return denoiser.run(*work, scale, rgb, nullptr, stream);
}

Result<void> CudaFilm::radiance_denoised(CudaDenoiser& denoiser, float voxel, float fade,
                                         float* rgb, cudaStream_t stream) const {
  const auto work = denoise_work(voxel, fade, stream);
  DIAPHANE_TRY(work);
  return denoiser.run(*work, 1.0f, nullptr, rgb, stream);
}

Result<void> CudaFilm::contents(std::uint8_t* met, cudaStream_t stream) const {
  std::vector<std::uint32_t> state(pixels());
  DIAPHANE_TRY(download(state.data(), state_, state.size(), stream));
  for (std::uint64_t i = 0; i < state.size(); ++i) met[i] = (state[i] & kHitMedium) != 0 ? 1 : 0;
  return {};
}

}  // namespace diaphane::render::cuda
