#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/frame_renderer.h"
#include "renderd/engine/thread_pool.h"
#include "renderd/film/error.h"
#include "renderd/film/film.h"
#include "renderd/kernel/estimator.h"

namespace diaphane::render {

/// The accumulated picture in host memory, 56 bytes a pixel; work over it is spread on the pool's
/// threads.
class CpuFilm {
 public:
  CpuFilm(ThreadPool& pool, Canvas size);

  /// One sample a pixel, to be written before fold().
  Sample* samples() { return samples_.data(); }
  /// Adds what samples() holds as the next sample of every pixel; the number of dropped ones.
  std::uint64_t fold();

  std::uint64_t count() const { return count_; }
  Canvas size() const { return size_; }
  std::uint64_t bytes() const {
    return samples_.size() * sizeof(Sample) + sum_.size() * sizeof(double) +
           difference_.size() * sizeof(float) + state_.size() * sizeof(std::uint32_t);
  }
  /// Estimated error of the whole picture (film/error.h); kept until the next fold.
  double error() const;
  void display(float scale, PictureRgb8& out) const;
  void radiance(PictureRgbF& out) const;
  void contents(std::vector<std::uint8_t>& out) const;

 private:
  ConstFilmView view() const { return {sum_.data(), difference_.data(), state_.data()}; }
  float white() const;

  ThreadPool& pool_;
  Canvas size_;
  std::uint64_t count_ = 0;
  std::vector<Sample> samples_;
  std::vector<double> sum_;
  std::vector<float> difference_;
  std::vector<std::uint32_t> state_;
  mutable double error_ = 0;
  mutable std::uint64_t error_of_ = 0;  ///< the count for which error_ was computed; 0: none yet
};

}  // namespace diaphane::render
