#include "volume/slice_interpolation.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <new>
#include <thread>
#include <vector>

#include "volume/slice_motion.h"

namespace diaphane::volume {
namespace {

/// Stored slices are refined if they are farther apart than this many pixels.
constexpr double kSteps = 1.3;
/// Motion is estimated on squares of averaged pixels of at most this width in mm, which is faster
/// than on single pixels and as exact, as long as the shorter side has kShortest of them.
constexpr double kMotionPixel = 2;
constexpr int kShortest = 64;
/// Motion by less than this, in pixels, does not change the interpolated values noticeably.
constexpr float kLeastMotion = 1.F / 32;

/// Returns the weight of the motion, from 0 to 1, where the slices differ by `straight` without it
/// and by `along` with it. Where they are alike anyway, such as in air, it must not bring values
/// from elsewhere.
float trust(float straight, float along) {
  const float without = std::abs(straight), with = std::abs(along);
  return without > 0 ? without / (without + with) : 0;
}

/// Makes the slices between pairs of stored ones. Different threads may make different pairs.
class Refiner {
 public:
  Refiner(const Volume& stored, std::uint32_t refinement, std::int16_t* refined)
      : stored_(stored),
        refinement_(refinement),
        refined_(refined),
        width_(static_cast<int>(stored.header.size[0])),
        height_(static_cast<int>(stored.header.size[1])) {
    const Header& header = stored.header;
    low_ = static_cast<float>(header.percentiles.front());
    scale_ = 1 / std::max(1.F, static_cast<float>(header.percentiles.back()) - low_);
    const double pixel = std::max(header.spacing[0], header.spacing[1]);
    const int most = std::max(std::min(width_, height_) / kShortest, 1);
    factor_ = std::clamp(static_cast<int>(kMotionPixel / pixel), 1, most);
  }

  /// Makes all slices between the centres of the stored slices `pair` and `pair` + 1.
  void fill(std::uint32_t pair) const {
    const SliceImage first = slice(pair), second = slice(pair + 1);
    const Motion motion = motion_between(first, second);
    for (std::uint32_t i = 0; i < refinement_; ++i) {
      const std::uint32_t z = first_beyond(pair) + i;
      const double at = (z + 0.5) / refinement_ - 0.5 - pair;
      interpolate(first, second, motion, static_cast<float>(at), z);
    }
  }

  /// Copies the first stored slice to all slices before its centre, and the last one to all slices
  /// from its centre on.
  void fill_ends() const {
    const std::uint32_t last = stored_.header.size[2] - 1;
    for (std::uint32_t z = 0; z < first_beyond(0); ++z) copy(0, z);
    for (std::uint32_t z = first_beyond(last); z < (last + 1) * refinement_; ++z) copy(last, z);
  }

 private:
  /// Returns the first refined slice that does not lie before the centre of stored slice `stored`.
  std::uint32_t first_beyond(std::uint32_t stored) const {
    return (2 * stored + 1) * refinement_ / 2;
  }
  std::size_t pixels() const { return static_cast<std::size_t>(width_) * height_; }

  SliceImage slice(std::uint32_t z) const {
    SliceImage plane(width_, height_);
    const std::int16_t* const from = stored_.voxels.data() + pixels() * z;
    std::copy(from, from + pixels(), plane.values.begin());
    return plane;
  }

  /// Maps the values between the header's percentiles to [0, 1], so that single bright voxels and
  /// the scale of the modality do not matter, and averages squares of `factor_` pixels.
  SliceImage normalised(const SliceImage& slice) const {
    SliceImage plane(width_ / factor_, height_ / factor_);
    const float share = 1.F / static_cast<float>(factor_ * factor_);
    for (int y = 0; y < plane.height * factor_; ++y) {
      float* const to = plane.row(y / factor_);
      const float* const from = slice.row(y);
      for (int x = 0; x < plane.width * factor_; ++x) {
        to[x / factor_] += share * std::clamp((from[x] - low_) * scale_, 0.F, 1.F);
      }
    }
    return plane;
  }

  /// Returns the motion in pixels of the stored slices.
  Motion motion_between(const SliceImage& first, const SliceImage& second) const {
    const Motion found = estimate_motion(normalised(first), normalised(second));
    if (factor_ == 1) return found;
    Motion motion{SliceImage(width_, height_), SliceImage(width_, height_)};
    const float scale = static_cast<float>(factor_);
    for (int y = 0; y < height_; ++y) {
      const float fy = (static_cast<float>(y) + 0.5F) / scale - 0.5F;
      for (int x = 0; x < width_; ++x) {
        const float fx = (static_cast<float>(x) + 0.5F) / scale - 0.5F;
        motion.x.row(y)[x] = scale * sample(found.x, fx, fy);
        motion.y.row(y)[x] = scale * sample(found.y, fx, fy);
      }
    }
    return motion;
  }

  void interpolate(const SliceImage& first, const SliceImage& second, const Motion& motion,
                   float at, std::uint32_t z) const {
    std::int16_t* to = refined_ + pixels() * z;
    for (int y = 0; y < height_; ++y) {
      const float* const mx = motion.x.row(y);
      const float* const my = motion.y.row(y);
      for (int x = 0; x < width_; ++x) {
        const float here = first.row(y)[x], there = second.row(y)[x];
        float value = here + at * (there - here);
        if (std::abs(mx[x]) + std::abs(my[x]) > kLeastMotion) {
          const float px = static_cast<float>(x), py = static_cast<float>(y);
          const float before = sample(first, px - at * mx[x], py - at * my[x]);
          const float after = sample(second, px + (1 - at) * mx[x], py + (1 - at) * my[x]);
          value += trust(here - there, before - after) * (before + at * (after - before) - value);
        }
        *to++ = static_cast<std::int16_t>(std::lrintf(value));
      }
    }
  }

  void copy(std::uint32_t from, std::uint32_t to) const {
    const std::int16_t* const begin = stored_.voxels.data() + pixels() * from;
    std::copy(begin, begin + pixels(), refined_ + pixels() * to);
  }

  const Volume& stored_;
  const std::uint32_t refinement_;
  std::int16_t* const refined_;
  const int width_, height_;
  float low_ = 0, scale_ = 1;
  int factor_ = 1;
};

/// Returns the labels of the thinner slices: each is a copy of the stored slice that it is part of,
/// because labels cannot be interpolated.
std::vector<std::uint8_t> refined_labels(const Volume& volume, std::uint32_t refinement) {
  const std::vector<std::uint8_t>& stored = volume.label_set.labels.voxels;
  std::vector<std::uint8_t> refined;
  refined.reserve(stored.size() * refinement);
  const auto pixels = static_cast<std::ptrdiff_t>(volume.header.size[0]) * volume.header.size[1];
  for (auto slice = stored.begin(); slice != stored.end(); slice += pixels) {
    for (std::uint32_t i = 0; i < refinement; ++i) {
      refined.insert(refined.end(), slice, slice + pixels);
    }
  }
  return refined;
}

}  // namespace

std::uint32_t refinement_of(const Header& header) {
  const double pixel = std::max(header.spacing[0], header.spacing[1]);
  const double ratio = header.spacing[2] / pixel;
  if (header.interpolated > 1 || ratio < kSteps || header.size[2] < 2) return 1;
  const double most = static_cast<double>(kMaxRefinedVoxels) /
                      static_cast<double>(std::max<std::uint64_t>(header.voxel_count(), 1));
  const double factor = std::min<double>(std::ceil(ratio - 0.1), kMaxRefinement);
  return static_cast<std::uint32_t>(std::max(1., std::floor(std::min(factor, most))));
}

void refine_slices(Volume& volume, std::uint32_t refinement, unsigned threads) {
  if (refinement <= 1 || volume.header.size[2] < 2) return;
  std::vector<std::int16_t> refined(volume.voxels.size() * refinement);
  const std::uint32_t pairs = volume.header.size[2] - 1;
  const Refiner refiner(volume, refinement, refined.data());
  refiner.fill_ends();
  std::atomic<std::uint32_t> next = 0;
  std::atomic<bool> out_of_memory = false;
  const auto work = [&] {
    try {
      for (std::uint32_t pair = next++; pair < pairs; pair = next++) refiner.fill(pair);
    } catch (const std::bad_alloc&) {
      out_of_memory = true;
      next = pairs;
    }
  };
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::clamp(threads, 1U, pairs); ++i) workers.emplace_back(work);
  }
  if (out_of_memory) throw std::bad_alloc();
  std::vector<std::uint8_t> labels = refined_labels(volume, refinement);
  volume.voxels = std::move(refined);
  volume.label_set.labels.voxels = std::move(labels);
  Header& header = volume.header;
  if (header.origin) {
    // The box stays, so the centre of the first, thinner slice is nearer to its face.
    const double shift = 0.5 * header.spacing[2] * (1 - 1.0 / refinement);
    for (std::size_t row = 0; row < 3; ++row) {
      (*header.origin)[row] -= shift * header.direction[3 * row + 2];
    }
  }
  header.size[2] *= refinement;
  header.spacing[2] /= refinement;
  if (!volume.label_set.empty()) volume.label_set.labels.size = header.size;
  header.interpolated = refinement;
}

Header stored_header(const Header& header) {
  Header stored = header;
  stored.size[2] /= header.interpolated;
  stored.spacing[2] *= header.interpolated;
  stored.origin.reset();
  stored.interpolated = 1;
  return stored;
}

}  // namespace diaphane::volume
