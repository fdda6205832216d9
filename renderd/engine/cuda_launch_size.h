#pragma once

#include <algorithm>
#include <cstdint>

namespace diaphane::render::cuda {

/// How much to put into one launch, so that it takes some milliseconds whatever the scene: long
/// enough to fill the device, short enough that a session that must stop, and others that share the
/// device, do not wait. Pure: it learns from what it is told. The size of a launch never changes a
/// picture, only the rows done at once.
class LaunchSize {
 public:
  static constexpr double kTargetMs = 8;

  /// Samples of pixels.
  std::uint64_t work() const { return work_; }

  /// A new scene, on a picture of so many pixels, with paths of so many collisions at most. Nothing
  /// is known of it but that a sample may cost `most_cost` times that of a single collision: the
  /// first launch is small.
  void forget(double most_cost = 1, std::uint64_t pixels = 1, std::uint32_t longest = 1) {
    work_ =
        std::max<std::uint64_t>(static_cast<std::uint64_t>(kFirst / std::max(most_cost, 1.0)), 1);
    // Rows of background say nothing of the dense ones below them, so growth has a bound until all
    // were seen, and a low one where paths may be very long.
    const double many = longest / kManyCollisions;
    unseen_most_ = longest > 1 ? 4 * kFirst / std::max(many * many, 1.0) : kLargest;
    pixels_ = unseen_ = std::max<std::uint64_t>(pixels, 1);
    fits_all_ = fits_seen_ = kLargest;
  }

  /// A launch of `work` took `ms`. What comes next fits the target by this launch, and by the most
  /// costly one of the last time that the whole picture was gone over. Grows at most fourfold.
  void learn(std::uint64_t work, double ms) {
    const double fits = ms > 0 ? static_cast<double>(work) * kTargetMs / ms : kLargest;
    // A short one of little work takes as long as its longest path, whatever its size.
    const bool telling = ms >= kTargetMs / 4 || static_cast<double>(work) >= kFirst / 16;
    if (telling) fits_seen_ = std::min(fits_seen_, fits);
    const double most = std::min(4 * static_cast<double>(work_), unseen_most_);
    work_ = static_cast<std::uint64_t>(
        std::clamp(std::min(fits, fits_all_), 1.0, std::clamp(most, 1.0, kLargest)));
    if (work < unseen_) {
      unseen_ -= work;
      return;
    }
    unseen_ = pixels_;
    fits_all_ = fits_seen_;
    fits_seen_ = unseen_most_ = kLargest;
  }

  /// Rows of `width` pixels with `samples` each; a multiple of `step`, at least one step.
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
  std::uint64_t pixels_ = 1, unseen_ = 1;  // of the picture; of it, in this turn
  double unseen_most_ = kLargest;          // work of a launch, at most, in the first turn
  double fits_all_ = kLargest, fits_seen_ = kLargest;  // work that fits: the last turn, this one
};

/// Threads that share a pixel's samples, as a power of two: as many as there are samples, up to
/// 2^`most`. The rays of one pixel stay together longer than those of its neighbours do: 32 threads
/// a pixel are a fifth faster than one on the cranium scene, and where few pixels are traced they
/// fill the device. Depends on nothing that is measured, since it decides the order of the sums.
inline std::uint32_t lane_shift_for(std::uint32_t samples, std::uint32_t most) {
  std::uint32_t shift = 0;
  while (shift < most && (2u << shift) <= samples) ++shift;
  return shift;
}

}  // namespace diaphane::render::cuda
