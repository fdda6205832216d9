#include "ingest/export/field.h"

#include <algorithm>
#include <cmath>

namespace diaphane::ingest {
namespace {

/// The largest sample, and the smallest absolute one. The surface crosses an edge of the grid where
/// linear interpolation gives 0. Because of the smallest sample, it stays away from the edge's ends
/// by 1/1500 of its length. Points of neighbouring edges are therefore never equal, not even as
/// floats in mm, which would open the surface.
constexpr double kLargest = 30000, kSmallest = 20;

/// Returns the value of a voxel relative to the surface.
class Distance {
 public:
  Distance(const volume::Volume& volume, const Inside& inside)
      : volume_(volume), inside_(inside), middle_(inside.above - 0.5) {
    const auto& header = volume.header;
    const double reach = std::max(header.maximum - middle_, middle_ - header.minimum);
    scale_ = kLargest / std::max(reach, 0.5);
  }
  bool is_inside(std::size_t voxel) const {
    return inside_.label > 0 ? volume_.label_set.labels.voxels[voxel] == inside_.label
                             : volume_.voxels[voxel] >= inside_.above;
  }
  double operator()(std::size_t voxel) const {
    if (inside_.label > 0) return is_inside(voxel) ? kLargest : -kLargest;
    return (volume_.voxels[voxel] - middle_) * scale_;
  }

 private:
  const volume::Volume& volume_;
  const Inside& inside_;
  double middle_;  // between two whole numbers, so that no voxel lies on the surface
  double scale_ = 1;
};

std::int16_t as_sample(double value) {
  const double size = std::clamp(std::abs(value), kSmallest, kLargest);
  return static_cast<std::int16_t>(std::lround(value > 0 ? size : -size));
}

using Index = std::array<std::uint32_t, 3>;

struct Box {
  Index low, high;
};

std::optional<Box> box_of(const volume::Header& header, const Distance& distance) {
  Box box{header.size, {0, 0, 0}};
  std::size_t voxel = 0;
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x, ++voxel) {
        if (!distance.is_inside(voxel)) continue;
        const Index at{x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          box.low[axis] = std::min(box.low[axis], at[axis]);
          box.high[axis] = std::max(box.high[axis], at[axis]);
        }
      }
    }
  }
  if (box.low[0] > box.high[0]) return std::nullopt;
  return box;
}

/// Returns the mean over the voxels of one sample. Those beyond the volume are outside.
double mean(const volume::Header& header, const Distance& distance,
            const std::array<std::int64_t, 3>& begin, std::uint32_t step) {
  const auto within = [&](std::size_t axis, std::int64_t at) {
    return at >= 0 && at < std::int64_t{header.size[axis]};
  };
  double sum = 0;
  for (std::int64_t z = begin[2]; z < begin[2] + step; ++z) {
    for (std::int64_t y = begin[1]; y < begin[1] + step; ++y) {
      for (std::int64_t x = begin[0]; x < begin[0] + step; ++x) {
        if (!within(0, x) || !within(1, y) || !within(2, z)) {
          sum -= kLargest;
          continue;
        }
        sum += distance(static_cast<std::size_t>(x + std::int64_t{header.size[0]} *
                                                         (y + std::int64_t{header.size[1]} * z)));
      }
    }
  }
  return sum / (double{static_cast<double>(step)} * step * step);
}

}  // namespace

std::optional<Field> sample_field(const volume::Volume& volume, const Inside& inside,
                                  std::uint32_t step, std::uint64_t most) {
  const Distance distance(volume, inside);
  const auto box = box_of(volume.header, distance);
  if (!box) return std::nullopt;
  Field field;
  field.step = step;
  for (;; field.step *= 2) {
    std::uint64_t count = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t side = box->high[axis] - box->low[axis] + 1;
      field.size[axis] = (side + field.step - 1) / field.step + 2;
      count *= field.size[axis];
    }
    if (count <= most) break;
  }
  const auto begin_of = [&](std::size_t axis, std::uint32_t sample) {
    return std::int64_t{box->low[axis]} + (std::int64_t{sample} - 1) * field.step;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    field.first[axis] = static_cast<double>(begin_of(axis, 0)) + (field.step - 1) / 2.0;
  }
  field.samples.reserve(std::size_t{field.size[0]} * field.size[1] * field.size[2]);
  for (std::uint32_t z = 0; z < field.size[2]; ++z) {
    for (std::uint32_t y = 0; y < field.size[1]; ++y) {
      for (std::uint32_t x = 0; x < field.size[0]; ++x) {
        field.samples.push_back(
            as_sample(mean(volume.header, distance,
                           {begin_of(0, x), begin_of(1, y), begin_of(2, z)}, field.step)));
      }
    }
  }
  return field;
}

std::uint64_t crossings(const Field& field) {
  const std::size_t row = field.size[0], slice = row * field.size[1];
  const auto& samples = field.samples;
  std::uint64_t count = 0;
  std::size_t at = 0;
  for (std::uint32_t z = 0; z < field.size[2]; ++z) {
    for (std::uint32_t y = 0; y < field.size[1]; ++y) {
      for (std::uint32_t x = 0; x < field.size[0]; ++x, ++at) {
        const bool inside = samples[at] > 0;
        if (x > 0 && inside != (samples[at - 1] > 0)) ++count;
        if (y > 0 && inside != (samples[at - row] > 0)) ++count;
        if (z > 0 && inside != (samples[at - slice] > 0)) ++count;
      }
    }
  }
  return count;
}

}  // namespace diaphane::ingest
