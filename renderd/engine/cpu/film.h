#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/engine/cpu/thread_pool.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/film/error.h"
#include "renderd/film/exposure.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/film/part.h"
#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// The accumulated picture in host memory: 56 bytes per pixel, 6 more with guides and 32 more while
/// guides are recorded. Functions divide their work among the threads of the pool.
class CpuFilm {
 public:
  /// `voxel` is the voxel size in mm, for guides.
  CpuFilm(RendererThreads& threads, Canvas size, bool guided = false, float voxel = 1);

  /// These implement FilmExchange::set_share(), take_film() and merge_film().
  Result<void> set_share(const Share& share);
  bool take(FilmPart& out);
  Result<void> merge(const FilmPart& part);
  /// These bound the rows of the share: [first_row(), last_row()).
  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t last_row() const { return last_row_; }
  /// Returns the number of the next sample in the sequence of the share.
  std::uint64_t drawn() const { return drawn_; }

  /// Returns the buffer for one sample per pixel. The renderer writes the rows of the share before
  /// it calls fold().
  Sample* samples() { return samples_.data(); }
  /// Adds the contents of samples() as the next sample of every pixel of the share. Returns the
  /// number of dropped samples.
  std::uint64_t fold();
  /// Returns the buffer for the guides of the next sample, similar to samples(). Returns null if no
  /// guides are recorded.
  Guides* guides() { return guide_samples_.empty() ? nullptr : guide_samples_.data(); }

  /// Returns the number of samples of the pixels with the fewest.
  std::uint64_t count() const { return count_; }
  /// Sets the curve of display() and of the error. The default is linear.
  void set_curve(ToneCurve curve) {
    curve_ = curve;
    error_.reset();
  }
  Canvas size() const { return size_; }
  /// Returns an upper bound of the memory for a picture of this size, including the guides.
  static std::uint64_t most_bytes(Canvas size, bool guided);
  std::uint64_t bytes() const {
    return samples_.size() * sizeof(Sample) + sum_.size() * sizeof(double) +
           difference_.size() * sizeof(float) + state_.size() * sizeof(std::uint32_t) +
           guide_samples_.size() * sizeof(Guides) + guides_.size() * sizeof(PackedGuides);
  }
  /// Returns the estimated error of the whole picture (film/error.h). The value is kept until the
  /// film changes.
  double error() const;
  /// Returns the mean radiance of the subject (film/exposure.h). The value is kept as well.
  double mean() const { return metering().mean; }
  void display(float scale, PictureRgb8& out) const;
  void radiance(PictureRgbF& out) const;
  void contents(std::vector<std::uint8_t>& out) const;
  /// Writes the denoised picture. Writes the raw picture and returns false if there are no guides
  /// or no samples, or if the picture no longer needs denoising. In the last case the guides are
  /// freed and all later pictures are raw.
  bool display_denoised(float scale, PictureRgb8& out);
  bool radiance_denoised(PictureRgbF& out);

 private:
  ConstFilmView view() const { return {sum_.data(), difference_.data(), state_.data()}; }
  std::uint64_t samples_of(std::uint32_t row) const {
    return by_stripe_.empty() ? count_ : by_stripe_[row / kShareRows];
  }
  /// Returns the number of samples of the share's rows that take() has not taken.
  std::uint64_t own() const { return drawn_ - taken_; }
  void recount();
  const Metering& metering() const;
  void fold_guides();
  /// Returns three numbers per pixel, or nothing if the picture is not denoised.
  std::vector<float> denoised();

  RendererThreads& threads_;
  Canvas size_;
  std::uint32_t first_row_ = 0, last_row_;
  std::uint64_t drawn_ = 0;            ///< samples since the share began
  std::uint64_t taken_ = 0;            ///< number of these samples that were taken
  std::vector<std::uint64_t> merged_;  ///< samples of other devices per kShareRows rows, or empty
  // recount() derives the next two members from those above.
  std::uint64_t count_ = 0;
  std::vector<std::uint64_t> by_stripe_;  ///< empty if all rows have the same number
  std::vector<Sample> samples_;
  std::vector<double> sum_;
  std::vector<float> difference_;
  std::vector<std::uint32_t> state_;
  std::vector<Guides> guide_samples_;
  std::vector<PackedGuides> guides_;
  float voxel_;
  ToneCurve curve_ = ToneCurve::kLinear;
  // These are empty if they were not computed since the film changed.
  mutable std::optional<Metering> metering_;
  mutable std::optional<double> error_;
};

}  // namespace diaphane::render
