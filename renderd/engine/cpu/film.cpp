#include "renderd/engine/cpu/film.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>

#include "renderd/engine/cpu/denoise.h"
#include "renderd/film/denoise.h"
#include "renderd/film/tone.h"

namespace diaphane::render {
namespace {

std::size_t pixels_of(Canvas size) { return std::size_t{size.width} * size.height; }

}  // namespace

CpuFilm::CpuFilm(RendererThreads& threads, Canvas size, bool guided, float voxel)
    : threads_(threads),
      size_(size),
      last_row_(size.height),
      samples_(pixels_of(size)),
      sum_(3 * pixels_of(size)),
      difference_(3 * pixels_of(size)),
      state_(pixels_of(size)),
      guide_samples_(guided ? pixels_of(size) : 0),
      guides_(guided ? pixels_of(size) : 0),
      voxel_(voxel) {}

std::uint64_t CpuFilm::most_bytes(Canvas size, bool guided) {
  constexpr std::uint64_t kPlain =
      sizeof(Sample) + 3 * sizeof(double) + 3 * sizeof(float) + sizeof(std::uint32_t);
  return pixels_of(size) * (kPlain + (guided ? sizeof(Guides) + sizeof(PackedGuides) : 0));
}

void CpuFilm::recount() {
  metering_.reset();
  error_.reset();
  by_stripe_.clear();
  count_ = own();
  const bool whole = first_row_ == 0 && last_row_ == size_.height;
  if (merged_.empty() && whole) return;
  by_stripe_ = merged_;
  by_stripe_.resize((size_.height + kShareRows - 1) / kShareRows, 0);
  for (std::uint32_t row = first_row_; row < last_row_; row += kShareRows) {
    by_stripe_[row / kShareRows] += own();
  }
  const auto [least, most] = std::minmax_element(by_stripe_.begin(), by_stripe_.end());
  count_ = *least;
  if (*least == *most) by_stripe_.clear();
}

Result<void> CpuFilm::set_share(const Share& share) {
  const std::uint32_t last = std::min(share.last_row, size_.height);
  if (!is_band(share.first_row, last, size_.height)) {
    return fail(ErrorCode::kInvalid, "a share must begin and end at a multiple of the row unit",
                "share");
  }
  if (own() % 2 != 0)
    return fail(ErrorCode::kConflict, "the second sample of a pair has not been rendered yet");
  if (own() > 0) {
    merged_.resize((size_.height + kShareRows - 1) / kShareRows, 0);
    for (std::uint32_t row = first_row_; row < last_row_; row += kShareRows) {
      merged_[row / kShareRows] += own();
    }
  }
  first_row_ = share.first_row;
  last_row_ = last;
  drawn_ = taken_ = 0;
  recount();
  return {};
}

bool CpuFilm::take(FilmPart& out) {
  if (own() == 0 || own() % 2 != 0) return false;
  out.width = size_.width;
  out.first_row = first_row_;
  out.rows = last_row_ - first_row_;
  out.samples = own();
  out.pixels.resize(std::size_t{out.width} * out.rows);
  out.guides.clear();
  if (!guides_.empty() && taken_ < kGuidedSamples && out.rows < size_.height) {
    const auto first = guides_.begin() + std::ptrdiff_t{out.width} * out.first_row;
    out.guides.assign(first, first + std::ptrdiff_t{out.width} * out.rows);
  }
  threads_.run(out.rows, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * (first_row_ + y);
    for (std::uint64_t x = 0; x < size_.width; ++x) {
      out.pixels[x + std::size_t{size_.width} * y] = pack_pixel(view(), first + x, out.samples);
      for (std::uint64_t i = 3 * (first + x); i < 3 * (first + x) + 3; ++i) {
        sum_[i] = 0;
        difference_[i] = 0;
      }
      state_[first + x] = 0;
    }
  });
  taken_ = drawn_;
  recount();
  return true;
}

Result<void> CpuFilm::merge(const FilmPart& part) {
  if (!fits(part, size_) || part.on_device) {
    return fail(ErrorCode::kInvalid, "this part belongs to a different picture", "part");
  }
  const FilmView film{sum_.data(), difference_.data(), state_.data()};
  threads_.run(part.rows, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * (part.first_row + y);
    for (std::uint64_t x = 0; x < size_.width; ++x) {
      merge_pixel(film, first + x, part.pixels[x + std::size_t{size_.width} * y], part.samples);
    }
  });
  if (!guides_.empty() && !part.guides.empty()) {
    std::copy(part.guides.begin(), part.guides.end(),
              guides_.begin() + std::ptrdiff_t{part.width} * part.first_row);
  }
  merged_.resize((size_.height + kShareRows - 1) / kShareRows, 0);
  for (std::uint32_t row = part.first_row; row < part.first_row + part.rows; row += kShareRows) {
    merged_[row / kShareRows] += part.samples;
  }
  recount();
  return {};
}

std::uint64_t CpuFilm::fold() {
  const FilmView film{sum_.data(), difference_.data(), state_.data()};
  std::atomic<std::uint64_t> dropped{0};
  threads_.run(last_row_ - first_row_, [&](std::uint32_t y) {
    std::uint64_t dropped_here = 0;
    const std::uint64_t first = std::uint64_t{size_.width} * (first_row_ + y);
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      PixelBatch batch;
      const Sample& sample = samples_[pixel];
      batch.add(sample.radiance, sample.hit_medium, drawn_, sample.shows_slice);
      dropped_here += batch.dropped_even + batch.dropped_odd;
      render::fold(film, pixel, batch);
    }
    if (dropped_here != 0) dropped += dropped_here;
  });
  if (!guide_samples_.empty()) fold_guides();
  ++drawn_;
  recount();
  return dropped;
}

void CpuFilm::fold_guides() {
  threads_.run(last_row_ - first_row_, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * (first_row_ + y);
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      guides_[pixel] = with_samples(guides_[pixel], static_cast<std::uint32_t>(drawn_),
                                    guide_samples_[pixel], 1);
    }
  });
  if (drawn_ + 1 >= kGuidedSamples) guide_samples_ = {};
}

std::vector<float> CpuFilm::denoised() {
  if (guides_.empty() || count_ == 0) return {};
  const float fade = denoiser_fade(error());
  if (!(fade > 0)) {
    guides_ = {};
    guide_samples_ = {};
    return {};
  }
  return denoise(threads_, {view(), guides_.data(), size_, count_, metering().white, voxel_, fade,
                            by_stripe_.empty() ? nullptr : by_stripe_.data()});
}

bool CpuFilm::display_denoised(float scale, PictureRgb8& out) {
  const std::vector<float> picture = denoised();
  if (picture.empty()) {
    display(scale, out);
    return false;
  }
  out.size = size_;
  out.pixels.resize(picture.size());
  threads_.run(size_.height, [&](std::uint32_t y) {
    const std::size_t first = std::size_t{3} * size_.width * y;
    for (std::size_t i = first; i < first + std::size_t{3} * size_.width; ++i) {
      out.pixels[i] = to_display(picture[i], scale, curve_);
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

const Metering& CpuFilm::metering() const {
  if (metering_) return *metering_;
  WhiteHistogram total;
  std::mutex mutex;
  threads_.run((size_.height + kShareRows - 1) / kShareRows, [&](std::uint32_t stripe) {
    WhiteHistogram part;
    const std::uint64_t first = std::uint64_t{size_.width} * kShareRows * stripe;
    const std::uint64_t last =
        std::min(first + std::uint64_t{size_.width} * kShareRows, std::uint64_t{pixels_of(size_)});
    count_white(view(), first, last, samples_of(kShareRows * stripe), part);
    std::lock_guard lock(mutex);
    for (std::uint32_t i = 0; i < kWhiteCounts; ++i) total.counts[i] += part.counts[i];
  });
  metering_ = metering_of(total);
  return *metering_;
}

double CpuFilm::error() const {
  static_assert(kTileSize == kShareRows);
  if (count_ < 2) return std::numeric_limits<double>::infinity();
  if (error_) return *error_;
  const float white = metering().white;
  const std::uint32_t tiles_x = (size_.width + kTileSize - 1) / kTileSize;
  const std::uint32_t tiles_y = (size_.height + kTileSize - 1) / kTileSize;
  std::vector<TileError> tiles(std::size_t{tiles_x} * tiles_y);
  threads_.run(tiles_y, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < tiles_x; ++x) {
      tiles[x + std::size_t{tiles_x} * y] =
          tile_error(view(), size_, x, y, samples_of(kTileSize * y), white, curve_);
    }
  });
  error_ = total_error(tiles, count_);
  return *error_;
}

void CpuFilm::display(float scale, PictureRgb8& out) const {
  out.size = size_;
  out.pixels.resize(3 * pixels_of(size_));
  threads_.run(size_.height, [&](std::uint32_t y) {
    const std::uint64_t first = std::uint64_t{size_.width} * y;
    for (std::uint64_t pixel = first; pixel < first + size_.width; ++pixel) {
      const Float3 mean = estimate_of(view(), pixel, samples_of(y)).mean;
      out.pixels[3 * pixel] = to_display(mean.x, scale, curve_);
      out.pixels[3 * pixel + 1] = to_display(mean.y, scale, curve_);
      out.pixels[3 * pixel + 2] = to_display(mean.z, scale, curve_);
    }
  });
}

void CpuFilm::radiance(PictureRgbF& out) const {
  out.size = size_;
  out.pixels.resize(3 * pixels_of(size_));
  for (std::uint64_t pixel = 0; pixel < pixels_of(size_); ++pixel) {
    const auto row = static_cast<std::uint32_t>(pixel / size_.width);
    const Float3 mean = estimate_of(view(), pixel, samples_of(row)).mean;
    out.pixels[3 * pixel] = mean.x;
    out.pixels[3 * pixel + 1] = mean.y;
    out.pixels[3 * pixel + 2] = mean.z;
  }
}

void CpuFilm::contents(std::vector<std::uint8_t>& out) const {
  out.resize(pixels_of(size_));
  for (std::size_t pixel = 0; pixel < out.size(); ++pixel) {
    out[pixel] = (state_[pixel] & kHitMedium) != 0 ? 1 : 0;
  }
}

}  // namespace diaphane::render
