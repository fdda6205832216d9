#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/engine/frame_renderer.h"
#include "renderd/engine/thread_pool.h"
#include "renderd/film/error.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/film/part.h"
#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// The accumulated picture in host memory, 56 bytes a pixel, 6 more with guides and 32 more while
/// they are recorded; work over it is spread on the pool's threads.
class CpuFilm {
 public:
  /// `voxel`: mm, for guides.
  CpuFilm(ThreadPool& pool, Canvas size, bool guided = false, float voxel = 1);

  /// As FrameRenderer::set_share(), take_film() and merge_film().
  Result<void> set_share(const Share& share);
  bool take(FilmPart& out);
  Result<void> merge(const FilmPart& part);
  /// The rows that the share is of: [first_row(), last_row()).
  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t last_row() const { return last_row_; }
  /// The number of the next sample in the share's sequence.
  std::uint64_t drawn() const { return drawn_; }

  /// One sample a pixel, to be written before fold(); the share's rows of it are.
  Sample* samples() { return samples_.data(); }
  /// Adds what samples() holds as the next sample of every pixel of the share; the number of
  /// dropped ones.
  std::uint64_t fold();
  /// What the next sample's guides are written to, as samples(); nothing when none are wanted.
  Guides* guides() { return guide_samples_.empty() ? nullptr : guide_samples_.data(); }

  /// Of the pixels that have the fewest.
  std::uint64_t count() const { return count_; }
  Canvas size() const { return size_; }
  std::uint64_t bytes() const {
    return samples_.size() * sizeof(Sample) + sum_.size() * sizeof(double) +
           difference_.size() * sizeof(float) + state_.size() * sizeof(std::uint32_t) +
           guide_samples_.size() * sizeof(Guides) + guides_.size() * sizeof(PackedGuides);
  }
  /// Estimated error of the whole picture (film/error.h); kept until the next fold.
  double error() const;
  void display(float scale, PictureRgb8& out) const;
  void radiance(PictureRgbF& out) const;
  void contents(std::vector<std::uint8_t>& out) const;
  /// Smoothed; false and the raw picture without guides, without samples or when the picture needs
  /// it no more, after which it is raw for good and the guides' memory is free.
  bool display_denoised(float scale, PictureRgb8& out);
  bool radiance_denoised(PictureRgbF& out);

 private:
  ConstFilmView view() const { return {sum_.data(), difference_.data(), state_.data()}; }
  std::uint64_t samples_of(std::uint32_t row) const {
    return by_stripe_.empty() ? count_ : by_stripe_[row / kShareRows];
  }
  /// Of the share's rows.
  std::uint64_t own() const { return drawn_ - taken_; }
  void recount();
  float white() const;
  void fold_guides();
  /// Three numbers a pixel, or none.
  std::vector<float> denoised();

  ThreadPool& pool_;
  Canvas size_;
  std::uint32_t first_row_ = 0, last_row_;
  std::uint64_t drawn_ = 0;            ///< since the share began
  std::uint64_t taken_ = 0;            ///< of those
  std::vector<std::uint64_t> merged_;  ///< from elsewhere, for each kShareRows rows; empty: none
  // Follow from those above.
  std::uint64_t count_ = 0;
  std::vector<std::uint64_t> by_stripe_;  ///< empty while it is the same everywhere
  std::vector<Sample> samples_;
  std::vector<double> sum_;
  std::vector<float> difference_;
  std::vector<std::uint32_t> state_;
  std::vector<Guides> guide_samples_;
  std::vector<PackedGuides> guides_;
  float voxel_;
  mutable std::optional<double> error_;  ///< nothing: not computed since the film changed
};

}  // namespace diaphane::render
