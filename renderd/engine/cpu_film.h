#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/frame_renderer.h"
#include "renderd/engine/thread_pool.h"
#include "renderd/film/error.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// The accumulated picture in host memory, 56 bytes a pixel, 6 more with guides and 32 more while
/// they are recorded; work over it is spread on the pool's threads.
class CpuFilm {
 public:
  /// `voxel`: mm, for guides.
  CpuFilm(ThreadPool& pool, Canvas size, bool guided = false, float voxel = 1);

  /// One sample a pixel, to be written before fold().
  Sample* samples() { return samples_.data(); }
  /// Adds what samples() holds as the next sample of every pixel; the number of dropped ones.
  std::uint64_t fold();
  /// What the next sample's guides are written to, as samples(); nothing when none are wanted.
  Guides* guides() { return guide_samples_.empty() ? nullptr : guide_samples_.data(); }

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
  float white() const;
  void fold_guides();
  /// Three numbers a pixel, or none.
  std::vector<float> denoised();

  ThreadPool& pool_;
  Canvas size_;
  std::uint64_t count_ = 0;
  std::vector<Sample> samples_;
  std::vector<double> sum_;
  std::vector<float> difference_;
  std::vector<std::uint32_t> state_;
  std::vector<Guides> guide_samples_;
  std::vector<PackedGuides> guides_;
  float voxel_;
  mutable double error_ = 0;
  mutable std::uint64_t error_of_ = 0;  ///< the count for which error_ was computed; 0: none yet
};

}  // namespace diaphane::render
