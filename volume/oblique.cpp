#include "volume/oblique.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "volume/slices.h"

namespace diaphane::volume {
namespace {

constexpr double kShortestStep = 1e-3, kLongestStep = 1e3;  // mm
constexpr double kFarthest = 1e6;                           // mm
/// Tolerance for unit vectors that pages compute in double precision.
constexpr double kPerpendicular = 1e-6;

double scalar_product(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool is_step(const Vector& vector) {
  const double length = std::sqrt(scalar_product(vector, vector));
  return length >= kShortestStep && length <= kLongestStep;  // false for NaN
}

double smallest_spacing(const Header& header) {
  return *std::min_element(header.spacing.begin(), header.spacing.end());
}

/// Faster than std::lerp, whose guarantees are not needed here.
double between(double a, double b, double part) { return a + (b - a) * part; }

/// A position or direction in voxels. Integers are the centres of voxels.
Vector in_voxels(const Header& header, const Vector& world) {
  Vector voxels{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < 3; ++k) voxels[a] += header.direction[3 * k + a] * world[k];
    voxels[a] /= header.spacing[a];
  }
  return voxels;
}

/// Interpolates at positions in voxels.
class Sampler {
 public:
  /// `kept` may be null, which means all voxels.
  Sampler(const Volume& volume, const KeptVoxels* kept)
      : voxels_(volume.voxels.data()), size_(volume.header.size), kept_(kept) {
    strides_ = {1, size_[0], std::size_t{size_[0]} * size_[1]};
    for (std::size_t a = 0; a < 3; ++a) last_[a] = size_[a] - 1.0;
  }

  std::optional<double> at(const Vector& position) const {
    std::array<std::uint32_t, 3> low{};
    std::array<double, 3> part{};
    std::size_t index = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!(position[a] >= -0.5 && position[a] <= last_[a] + 0.5)) return std::nullopt;
      const double held = std::clamp(position[a], 0.0, last_[a]);
      low[a] = static_cast<std::uint32_t>(held);
      part[a] = held - low[a];
      index += low[a] * strides_[a];
    }
    if (kept_ && !all_kept(low, part)) return std::nullopt;
    // A step of 0 where the second voxel has no weight, because it may not exist.
    const std::size_t x = part[0] > 0 ? strides_[0] : 0;
    const std::size_t y = part[1] > 0 ? strides_[1] : 0;
    const std::size_t z = part[2] > 0 ? strides_[2] : 0;
    const auto line = [&](std::size_t from) {
      return between(voxels_[from], voxels_[from + x], part[0]);
    };
    const auto plane = [&](std::size_t from) {
      return between(line(from), line(from + y), part[1]);
    };
    return between(plane(index), plane(index + z), part[2]);
  }

 private:
  bool all_kept(const std::array<std::uint32_t, 3>& low, const std::array<double, 3>& part) const {
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const std::uint32_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const bool counts = (!x || part[0] > 0) && (!y || part[1] > 0) && (!z || part[2] > 0);
      if (counts && !kept_->keeps(low[0] + x, low[1] + y, low[2] + z)) return false;
    }
    return true;
  }

  const std::int16_t* voxels_;
  std::array<std::uint32_t, 3> size_;
  const KeptVoxels* kept_;
  std::array<std::size_t, 3> strides_{};
  Vector last_{};
};

/// The samples of one pixel.
class Combined {
 public:
  explicit Combined(Projection projection) : projection_(projection) {}

  void add(double value) {
    ++count_;
    sum_ += value;
    least_ = std::min(least_, value);
    most_ = std::max(most_, value);
  }
  std::int16_t value(std::int16_t none) const {
    if (count_ == 0) return none;
    const double exact = projection_ == Projection::kMaximum   ? most_
                         : projection_ == Projection::kMinimum ? least_
                                                               : sum_ / count_;
    return static_cast<std::int16_t>(std::lround(exact));
  }

 private:
  Projection projection_;
  int count_ = 0;
  double sum_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
};

std::vector<std::int16_t> read(const Volume& volume, const ObliqueSlice& slice, std::int16_t none,
                               const KeptVoxels* kept) {
  const Header& header = volume.header;
  const Sampler sampler(volume, kept);
  const std::uint64_t layers = layers_of(header, slice.thickness);
  Vector step = normal_of(slice);
  for (double& entry : step) entry *= layers > 1 ? slice.thickness / double(layers - 1) : 0;
  Vector first = in_voxels(header, slice.first);
  const Vector right = in_voxels(header, slice.right);
  const Vector down = in_voxels(header, slice.down);
  const Vector through = in_voxels(header, step);
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] += header.size[a] / 2.0 - 0.5 - double(layers - 1) / 2 * through[a];
  }
  std::vector<std::int16_t> values;
  values.reserve(std::size_t{slice.columns} * slice.rows);
  for (std::uint32_t row = 0; row < slice.rows; ++row) {
    for (std::uint32_t column = 0; column < slice.columns; ++column) {
      Combined combined(slice.projection);
      for (std::uint64_t layer = 0; layer < layers; ++layer) {
        Vector at{};
        for (std::size_t a = 0; a < 3; ++a) {
          at[a] = first[a] + column * right[a] + row * down[a] + double(layer) * through[a];
        }
        if (const auto value = sampler.at(at)) combined.add(*value);
      }
      values.push_back(combined.value(none));
    }
  }
  return values;
}

}  // namespace

std::uint64_t layers_of(const Header& header, double thickness) {
  if (thickness <= 0) return 1;
  return 1 + static_cast<std::uint64_t>(std::ceil(thickness / smallest_spacing(header) - 1e-9));
}

std::uint64_t samples_of(const Header& header, const ObliqueSlice& slice) {
  return std::uint64_t{slice.columns} * slice.rows * layers_of(header, slice.thickness);
}

Vector normal_of(const ObliqueSlice& slice) {
  const auto& [a, b] = std::pair{slice.right, slice.down};
  Vector normal{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const double length = std::sqrt(scalar_product(normal, normal));
  for (double& entry : normal) entry /= length;
  return normal;
}

Result<void> check(const Header& header, const ObliqueSlice& slice) {
  const auto refuse = [](const char* field) {
    return fail(ErrorCode::kInvalid, "This oblique slice is not valid.", field);
  };
  for (const double entry : slice.first) {
    if (!(std::abs(entry) <= kFarthest)) return refuse("first");
  }
  if (!is_step(slice.right)) return refuse("right");
  if (!is_step(slice.down)) return refuse("down");
  const double lengths = std::sqrt(scalar_product(slice.right, slice.right)) *
                         std::sqrt(scalar_product(slice.down, slice.down));
  if (std::abs(scalar_product(slice.right, slice.down)) > kPerpendicular * lengths)
    return refuse("down");
  if (slice.columns < 1 || slice.columns > kMostObliqueSide) return refuse("columns");
  if (slice.rows < 1 || slice.rows > kMostObliqueSide) return refuse("rows");
  // A huge quotient would overflow the number of samples.
  if (!(slice.thickness >= 0 &&
        slice.thickness / smallest_spacing(header) <= double(kMostSamples)) ||
      samples_of(header, slice) > kMostSamples) {
    return fail(ErrorCode::kInvalid, "This slab is too thick for its number of pixels.",
                "thickness");
  }
  return {};
}

std::vector<std::int16_t> sample(const Volume& volume, const ObliqueSlice& slice) {
  return read(volume, slice, value_outside(volume.header), nullptr);
}

std::vector<std::int16_t> sample_clipped(const Volume& volume, const ObliqueSlice& slice,
                                         const KeptVoxels& kept) {
  return read(volume, slice, kBlank, &kept);
}

}  // namespace diaphane::volume
