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

  /// Samples of pixels; the first launch of a scene is small, since nothing is known of it but that
  /// a sample may cost `most_cost` times that of a single collision.
  std::uint64_t work() const { return work_; }
  void forget(double most_cost = 1) {
    work_ = static_cast<std::uint64_t>(static_cast<double>(kFirst) / std::max(most_cost, 1.0));
    work_ = std::max<std::uint64_t>(work_, 1);
  }

  /// A launch of `work` took `ms`. Grows at most fourfold: a stripe of background says little of
  /// what comes.
  void learn(std::uint64_t work, double ms) {
    const double wanted = ms > 0 ? static_cast<double>(work) * kTargetMs / ms : kLargest;
    const double most = 4 * static_cast<double>(work_);
    work_ = static_cast<std::uint64_t>(std::clamp(wanted, 1.0, std::min(most, kLargest)));
  }

  /// Rows of `width` pixels with `samples` each; a multiple of `step`, at least one step.
  std::uint32_t rows(std::uint32_t width, std::uint32_t samples, std::uint32_t step) const {
    const std::uint64_t a_step = std::uint64_t{width} * samples * step;
    const std::uint64_t steps = std::clamp<std::uint64_t>(work_ / a_step, 1, 65536 / step);
    return static_cast<std::uint32_t>(steps) * step;
  }

 private:
  static constexpr std::uint64_t kFirst = 1 << 18;
  static constexpr double kLargest = 1e12;
  std::uint64_t work_ = kFirst;
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
