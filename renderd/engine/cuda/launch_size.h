#pragma once

#include <algorithm>
#include <cstdint>

namespace diaphane::render::cuda {

/// Chooses the size of the next launch, so that it takes some milliseconds for any scene. That is
/// long enough to fill the device, and short enough that stopping is quick and other sessions of
/// the device do not wait. The choice depends only on the times passed to learn(). The size of a
/// launch never changes a picture, only how many rows are done at once.
class LaunchSize {
 public:
  static constexpr double kTargetMs = 8;

  /// Returns the size of the next launch: pixels times samples per pixel.
  std::uint64_t work() const { return work_; }

  /// Starts a new scene with a picture of `pixels` pixels and paths of at most `longest`
  /// collisions. Its cost is unknown, except that a sample may cost up to `most_cost` times as much
  /// as a single collision, so the first launch is small.
  void forget(double most_cost = 1, std::uint64_t pixels = 1, std::uint32_t longest = 1) {
    work_ =
        std::max<std::uint64_t>(static_cast<std::uint64_t>(kFirst / std::max(most_cost, 1.0)), 1);
    // The cost of background rows does not predict that of dense rows below them, so growth is
    // limited until the whole picture was rendered once. The longer the paths, the lower the limit.
    const double many = longest / kManyCollisions;
    unseen_most_ = longest > 1 ? 4 * kFirst / std::max(many * many, 1.0) : kLargest;
    pixels_ = unseen_ = std::max<std::uint64_t>(pixels, 1);
    fits_all_ = fits_seen_ = kLargest;
  }

  /// Records that a launch of `work`, with `samples` samples per pixel, took `ms`. The next size
  /// meets the target according to this launch and to the most expensive launch of the previous
  /// pass over the picture. It grows at most by a factor of four.
  void learn(std::uint64_t work, double ms, std::uint32_t samples = 1) {
    const double fits = ms > 0 ? static_cast<double>(work) * kTargetMs / ms : kLargest;
    // A short launch with little work takes as long as its longest path, whatever its size.
    const bool informative = ms >= kTargetMs / 4 || static_cast<double>(work) >= kFirst / 16;
    if (informative) fits_seen_ = std::min(fits_seen_, fits);
    const double most = std::min(4 * static_cast<double>(work_), unseen_most_);
    work_ = static_cast<std::uint64_t>(
        std::clamp(std::min(fits, fits_all_), 1.0, std::clamp(most, 1.0, kLargest)));
    const std::uint64_t pixels = work / std::max(samples, 1u);
    if (pixels < unseen_) {
      unseen_ -= pixels;
      return;
    }
    unseen_ = pixels_;
    fits_all_ = fits_seen_;
    fits_seen_ = unseen_most_ = kLargest;
  }

  /// Returns the number of rows of `width` pixels with `samples` samples per pixel that fit into
  /// the next launch, a multiple of `step` and at least one step.
  std::uint32_t rows(std::uint32_t width, std::uint32_t samples, std::uint32_t step) const {
    const std::uint64_t a_step = std::uint64_t{width} * samples * step;
    const std::uint64_t steps = std::clamp<std::uint64_t>(work_ / a_step, 1, 65536 / step);
    return static_cast<std::uint32_t>(steps) * step;
  }

 private:
  static constexpr double kFirst = 1 << 18;
  static constexpr double kManyCollisions = 128;
  static constexpr double kLargest = 1e12;
  std::uint64_t work_ = static_cast<std::uint64_t>(kFirst);
  std::uint64_t pixels_ = 1, unseen_ = 1;  // of the picture; not yet rendered in this pass
  double unseen_most_ = kLargest;          // maximum work of a launch in the first pass
  // Work that meets the target, according to the last pass and to this pass so far.
  double fits_all_ = kLargest, fits_seen_ = kLargest;
};

/// Returns log2 of the number of threads that share the samples of a pixel. There are at most as
/// many threads as samples, and at most 2^`most`. The rays of one pixel stay together longer than
/// the rays of neighbouring pixels. On the cranium scene, 32 threads per pixel are a fifth faster
/// than one, and they fill the device even if few pixels are traced. The result must not depend on
/// measurements, because it decides the order of the sums.
inline std::uint32_t lane_shift_for(std::uint32_t samples, std::uint32_t most) {
  std::uint32_t shift = 0;
  while (shift < most && (2u << shift) <= samples) ++shift;
  return shift;
}

}  // namespace diaphane::render::cuda
