#include "volume/slices.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::volume {
namespace {

// A direction in a stack: an axis of the patient and a sign.
struct Way {
  std::size_t axis;
  double sign;
};
struct Ways {
  Way right, down, next;
};

Ways ways_of(Plane plane) {
  switch (plane) {
    case Plane::kCoronal:
      return {{0, 1}, {2, -1}, {1, 1}};
    case Plane::kSagittal:
      return {{1, 1}, {2, -1}, {0, 1}};
    case Plane::kAxial:
      break;
  }
  return {{0, 1}, {1, 1}, {2, 1}};
}

// Returns the direction, rounded to a rotation by right angles if it differs from one only by
// rounding errors.
std::array<double, 9> axes_of(const Header& header) {
  std::array<double, 9> axes = header.direction;
  for (double& entry : axes) {
    const double rounded = std::round(entry);
    if (std::abs(entry - rounded) > kAligned) return header.direction;
    entry = rounded;
  }
  return axes;
}

bool is_aligned(const std::array<double, 9>& axes) {
  return std::all_of(axes.begin(), axes.end(),
                     [](double entry) { return entry == std::round(entry); });
}

struct Extent {
  double step = 0;  // mm
  std::uint32_t count = 0;
};

// Returns the step and the number of steps along one axis of the patient.
Extent extent_of(const Header& header, const std::array<double, 9>& axes, std::size_t axis) {
  double length = 0;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    const double along = std::abs(axes[3 * axis + a]);
    length += along * header.size[a] * header.spacing[a];
    if (along > 0) step = std::min(step, header.spacing[a] / along);
  }
  const double count = std::max(1.0, std::round(length / step));
  if (is_aligned(axes) || count <= kMostOblique) return {step, static_cast<std::uint32_t>(count)};
  return {length / kMostOblique, kMostOblique};
}

Vector along(const Way& way, double mm) {
  Vector vector{};
  vector[way.axis] = way.sign * mm;
  return vector;
}

}  // namespace

SliceStack plan_stack(const Header& header, Plane plane) {
  const auto axes = axes_of(header);
  const Ways ways = ways_of(plane);
  const Extent right = extent_of(header, axes, ways.right.axis);
  const Extent down = extent_of(header, axes, ways.down.axis);
  const Extent next = extent_of(header, axes, ways.next.axis);
  SliceStack stack;
  stack.plane = plane;
  stack.columns = right.count;
  stack.rows = down.count;
  stack.slices = next.count;
  stack.right = along(ways.right, right.step);
  stack.down = along(ways.down, down.step);
  stack.next = along(ways.next, next.step);
  // The stack is centred in the box, and the box is centred at the world's origin.
  for (std::size_t k = 0; k < 3; ++k) {
    stack.first[k] = -((right.count - 1.0) * stack.right[k] + (down.count - 1.0) * stack.down[k] +
                       (next.count - 1.0) * stack.next[k]) /
                     2;
  }
  return stack;
}

namespace {

// Reads a slice. `kept` may be null, which means all voxels.
Result<std::vector<std::int16_t>> read_slice(const Volume& volume, const SliceStack& stack,
                                             std::uint32_t index, std::int16_t outside,
                                             const KeptVoxels* kept) {
  if (index >= stack.slices)
    return fail(ErrorCode::kInvalid, "This slice does not exist.", "index");
  const Header& header = volume.header;
  const auto axes = axes_of(header);
  // Positions are in voxels from the corner of the box, so the integer part is the voxel's index.
  const auto in_voxels = [&](const Vector& world) {
    Vector voxels{};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t k = 0; k < 3; ++k) voxels[a] += axes[3 * k + a] * world[k];
      voxels[a] /= header.spacing[a];
    }
    return voxels;
  };
  const Vector first = in_voxels(stack.first);
  const Vector right = in_voxels(stack.right);
  const Vector down = in_voxels(stack.down);
  const Vector next = in_voxels(stack.next);

  std::vector<std::int16_t> values(stack.pixels(), outside);
  auto value = values.begin();
  for (std::uint32_t row = 0; row < stack.rows; ++row) {
    Vector begin{};
    for (std::size_t a = 0; a < 3; ++a) {
      begin[a] = first[a] + header.size[a] / 2.0 + index * next[a] + row * down[a];
    }
    for (std::uint32_t column = 0; column < stack.columns; ++column, ++value) {
      std::array<std::int64_t, 3> voxel{};
      bool inside = true;
      for (std::size_t a = 0; a < 3; ++a) {
        voxel[a] = static_cast<std::int64_t>(std::floor(begin[a] + column * right[a]));
        inside = inside && voxel[a] >= 0 && voxel[a] < std::int64_t{header.size[a]};
      }
      if (!inside) continue;
      if (kept &&
          !kept->keeps(static_cast<std::uint32_t>(voxel[0]), static_cast<std::uint32_t>(voxel[1]),
                       static_cast<std::uint32_t>(voxel[2]))) {
        continue;
      }
      *value = volume.voxels[static_cast<std::size_t>(
          voxel[0] + header.size[0] * (voxel[1] + header.size[1] * voxel[2]))];
    }
  }
  return values;
}

}  // namespace

std::int16_t value_outside(const Header& header) {
  return static_cast<std::int16_t>(
      std::clamp(header.minimum, std::int32_t{std::numeric_limits<std::int16_t>::min()},
                 std::int32_t{std::numeric_limits<std::int16_t>::max()}));
}

Result<std::vector<std::int16_t>> slice_of(const Volume& volume, const SliceStack& stack,
                                           std::uint32_t index) {
  return read_slice(volume, stack, index, value_outside(volume.header), nullptr);
}

Result<std::vector<std::int16_t>> clipped_slice_of(const Volume& volume, const SliceStack& stack,
                                                   std::uint32_t index, const KeptVoxels& kept) {
  return read_slice(volume, stack, index, kBlank, &kept);
}

}  // namespace diaphane::volume
