#include "renderd/engine/cpu_film.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>

#include "renderd/engine/cpu_denoise.h"
#include "renderd/film/denoise.h"
#include "renderd/film/tone.h"

namespace diaphane::render {
namespace {

std::size_t pixels_of(Canvas size) { return std::size_t{size.width} * size.height; }

}  // namespace

CpuFilm::CpuFilm(ThreadPool& pool, Canvas size, bool guided, float voxel)
    : pool_(pool),
      size_(size),
      samples_(pixels_of(size)),
      sum_(3 * pixels_of(size)),
      difference_(3 * pixels_of(size)),
      state_(pixels_of(size)),
      guide_samples_(guided ? pixels_of(size) : 0),
      guides_(guided ? pixels_of(size) : 0),
      voxel_(voxel) {}

std::uint64_t CpuFilm::fold() {
  const FilmView film{sum_.data(), difference_.data(), state_.data()};
  std::atomic<std::uint64_t> dropped{0};
  pool_.run(size_.height, [&](std::uint32_t y) {
    std::uint64_t dropped_here = 0;
    const std::uint64_t first = std::uint64_t{size_.width} * y;
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      PixelBatch batch;
      const Sample& sample = samples_[pixel];
      batch.add(sample.radiance, sample.met_matter, count_, sample.shows_slice);
      dropped_here += batch.dropped_even + batch.dropped_odd;
      render::fold(film, pixel, batch);
    }
    if (dropped_here != 0) dropped += dropped_here;
  });
  if (!guide_samples_.empty()) fold_guides();
  ++count_;
  return dropped;
}

void CpuFilm::fold_guides() {
  pool_.run(size_.height, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * y;
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      guides_[pixel] = with_samples(guides_[pixel], static_cast<std::uint32_t>(count_),
                                    guide_samples_[pixel], 1);
    }
  });
  if (count_ + 1 >= kGuidedSamples) guide_samples_ = {};
}

std::vector<float> CpuFilm::denoised() {
  if (guides_.empty() || count_ == 0) return {};
  const float fade = denoiser_fade(error());
  if (!(fade > 0)) {
    guides_ = {};
    guide_samples_ = {};
    return {};
  }
  return denoise(pool_, {view(), guides_.data(), size_, count_, white(), voxel_, fade});
}

bool CpuFilm::display_denoised(float scale, PictureRgb8& out) {
  const std::vector<float> picture = denoised();
  if (picture.empty()) {
    display(scale, out);
    return false;
  }
  out.size = size_;
  out.pixels.resize(picture.size());
  pool_.run(size_.height, [&](std::uint32_t y) {
    const std::size_t first = std::size_t{3} * size_.width * y;
    for (std::size_t i = first; i < first + std::size_t{3} * size_.width; ++i) {
      out.pixels[i] = to_display(picture[i], scale);
    }
  });
  return true;
}

bool CpuFilm::radiance_denoised(PictureRgbF& out) {
  std::vector<float> picture = denoised();
  if (picture.empty()) {
    radiance(out);
    return false;
  }
  out.size = size_;
  out.pixels = std::move(picture);
  return true;
}

float CpuFilm::white() const {
  WhiteHistogram total;
  std::mutex mutex;
  constexpr std::uint32_t kRows = 32;
  pool_.run((size_.height + kRows - 1) / kRows, [&](std::uint32_t block) {
    WhiteHistogram part;
    const std::uint64_t first = std::uint64_t{size_.width} * kRows * block;
    const std::uint64_t last =
        std::min(first + std::uint64_t{size_.width} * kRows, std::uint64_t{pixels_of(size_)});
    count_white(view(), first, last, count_, part);
    std::lock_guard lock(mutex);
    for (std::uint32_t i = 0; i < kWhiteCounts; ++i) total.counts[i] += part.counts[i];
  });
  return white_from_histogram(total);
}

double CpuFilm::error() const {
  if (count_ < 2) return std::numeric_limits<double>::infinity();
  if (error_of_ == count_) return error_;
  const float white_value = white();
  const std::uint32_t tiles_x = (size_.width + kTileSize - 1) / kTileSize;
  const std::uint32_t tiles_y = (size_.height + kTileSize - 1) / kTileSize;
  std::vector<TileError> tiles(std::size_t{tiles_x} * tiles_y);
  pool_.run(tiles_y, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < tiles_x; ++x) {
      tiles[x + std::size_t{tiles_x} * y] = tile_error(view(), size_, x, y, count_, white_value);
    }
  });
  error_ = total_error(tiles, count_);
  error_of_ = count_;
  return error_;
}

void CpuFilm::display(float scale, PictureRgb8& out) const {
  out.size = size_;
  out.pixels.resize(3 * pixels_of(size_));
  pool_.run(size_.height, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * y;
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      const Float3 mean = estimate_of(view(), pixel, count_).mean;
      out.pixels[3 * pixel] = to_display(mean.x, scale);
      out.pixels[3 * pixel + 1] = to_display(mean.y, scale);
      out.pixels[3 * pixel + 2] = to_display(mean.z, scale);
    }
  });
}

void CpuFilm::radiance(PictureRgbF& out) const {
  out.size = size_;
  out.pixels.resize(3 * pixels_of(size_));
  for (std::uint64_t pixel = 0; pixel < pixels_of(size_); ++pixel) {
    const Float3 mean = estimate_of(view(), pixel, count_).mean;
    out.pixels[3 * pixel] = mean.x;
    out.pixels[3 * pixel + 1] = mean.y;
    out.pixels[3 * pixel + 2] = mean.z;
  }
}

void CpuFilm::contents(std::vector<std::uint8_t>& out) const {
  out.resize(pixels_of(size_));
  for (std::size_t pixel = 0; pixel < out.size(); ++pixel) {
    out[pixel] = (state_[pixel] & kMetMatter) != 0 ? 1 : 0;
  }
}

}  // namespace diaphane::render
