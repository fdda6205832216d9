#include "renderd/scene/grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace diaphane::render {
namespace {

constexpr ValueRange kNothing{std::numeric_limits<std::int16_t>::max(),
                              std::numeric_limits<std::int16_t>::min()};

void include(ValueRange& range, ValueRange other) {
  range.minimum = std::min(range.minimum, other.minimum);
  range.maximum = std::max(range.maximum, other.maximum);
}

/// The cells whose extended voxel range [8i - 1, 8i + 8] contains voxel `v`.
struct CellsOfVoxel {
  std::int32_t first, last;
};
CellsOfVoxel cells_of(std::int32_t v, std::int32_t cells) {
  return {std::max((v - 1) >> kCellShift, 0), std::min((v + 1) >> kCellShift, cells - 1)};
}

/// Computes the range of each cell along one row of voxels.
void row_ranges(const std::int16_t* row, std::int32_t size, std::span<ValueRange> out) {
  for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(out.size()); ++cell) {
    const std::int32_t first = std::max(cell * kCellSize - 1, 0);
    const std::int32_t last = std::min(cell * kCellSize + kCellSize, size - 1);
    ValueRange range = kNothing;
    for (std::int32_t x = first; x <= last; ++x) include(range, {row[x], row[x]});
    out[static_cast<std::size_t>(cell)] = range;
  }
}

/// Computes the range of each brick. Brick b has the cells 4b to 4b + 3, with corners at the voxels
/// 4b - 1 to 4b + 3.
std::vector<ValueRange> brick_ranges_of(std::span<const std::int16_t> voxels, Int3 size,
                                        Int3 bricks) {
  const auto voxels_of = [](std::int32_t brick, std::int32_t n, std::int32_t& first,
                            std::int32_t& last) {
    first = std::max(brick * kBrickSize - 1, 0);
    last = std::min(brick * kBrickSize + kBrickSize - 1, n - 1);
  };
  std::vector<ValueRange> ranges(static_cast<std::size_t>(bricks.x) *
                                     static_cast<std::size_t>(bricks.y) *
                                     static_cast<std::size_t>(bricks.z),
                                 kNothing);
  std::size_t out = 0;
  for (std::int32_t bz = 0; bz < bricks.z; ++bz) {
    std::int32_t z0, z1;
    voxels_of(bz, size.z, z0, z1);
    for (std::int32_t by = 0; by < bricks.y; ++by, out += static_cast<std::size_t>(bricks.x)) {
      std::int32_t y0, y1;
      voxels_of(by, size.y, y0, y1);
      for (std::int32_t z = z0; z <= z1; ++z) {
        for (std::int32_t y = y0; y <= y1; ++y) {
          const std::int16_t* row = voxels.data() + size.x * (y + std::int64_t{size.y} * z);
          for (std::int32_t bx = 0; bx < bricks.x; ++bx) {
            std::int32_t x0, x1;
            voxels_of(bx, size.x, x0, x1);
            ValueRange& range = ranges[out + static_cast<std::size_t>(bx)];
            for (std::int32_t x = x0; x <= x1; ++x) include(range, {row[x], row[x]});
          }
        }
      }
    }
  }
  return ranges;
}

bool is_rotation(const std::array<double, 9>& d) {
  for (double value : d) {
    if (!std::isfinite(value)) return false;
  }
  constexpr double kTolerance = 1e-4;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double product = 0;
      for (int k = 0; k < 3; ++k) product += d[3 * k + i] * d[3 * k + j];
      if (std::abs(product - (i == j ? 1.0 : 0.0)) > kTolerance) return false;
    }
  }
  const double determinant = d[0] * (d[4] * d[8] - d[5] * d[7]) -
                             d[1] * (d[3] * d[8] - d[5] * d[6]) +
                             d[2] * (d[3] * d[7] - d[4] * d[6]);
  return determinant > 0;
}

}  // namespace

Int3 size_of(const volume::Header& header) {
  return {static_cast<std::int32_t>(header.size[0]), static_cast<std::int32_t>(header.size[1]),
          static_cast<std::int32_t>(header.size[2])};
}

Result<void> check_volume(const volume::Volume& volume) {
  const volume::Header& h = volume.header;
  for (std::uint32_t n : h.size) {
    if (n == 0 || n > kLongestAxis) {
      return fail(ErrorCode::kInvalid, "each axis of a volume must have 1 to 8192 voxels", "size");
    }
  }
  if (h.voxel_count() != volume.voxels.size()) {
    return fail(ErrorCode::kInvalid, "the number of voxels does not match the header", "size");
  }
  for (double s : h.spacing) {
    if (!std::isfinite(s) || s < 1e-6 || s > 1e6) {
      return fail(ErrorCode::kInvalid, "the spacing must be from 1e-6 to 1e6 mm", "spacing");
    }
  }
  if (!is_rotation(h.direction)) {
    return fail(ErrorCode::kInvalid, "the direction must be a rotation", "direction");
  }
  const volume::LabelSet& set = volume.label_set;
  const auto beyond = [&](std::uint8_t label) { return label > set.table.size(); };
  if (!set.empty() &&
      (set.labels.voxels.size() != volume.voxels.size() || set.table.size() > volume::kMostLabels ||
       std::any_of(set.labels.voxels.begin(), set.labels.voxels.end(), beyond))) {
    return fail(ErrorCode::kInvalid, "the labels do not match the volume", "labels");
  }
  return {};
}

ValueGrid make_value_grid(std::span<const std::int16_t> voxels, Int3 size) {
  const auto cells_along = [](std::int32_t n) { return (n + kCellSize - 1) >> kCellShift; };
  ValueGrid grid;
  grid.cells = {cells_along(size.x), cells_along(size.y), cells_along(size.z)};
  const auto cells_x = static_cast<std::size_t>(grid.cells.x);
  grid.ranges.assign(
      cells_x * static_cast<std::size_t>(grid.cells.y) * static_cast<std::size_t>(grid.cells.z),
      kNothing);
  std::vector<ValueRange> row(cells_x);
  for (std::int32_t z = 0; z < size.z; ++z) {
    const CellsOfVoxel along_z = cells_of(z, grid.cells.z);
    for (std::int32_t y = 0; y < size.y; ++y) {
      const CellsOfVoxel along_y = cells_of(y, grid.cells.y);
      row_ranges(voxels.data() + size.x * (y + std::int64_t{size.y} * z), size.x, row);
      for (std::int32_t cz = along_z.first; cz <= along_z.last; ++cz) {
        for (std::int32_t cy = along_y.first; cy <= along_y.last; ++cy) {
          ValueRange* target =
              grid.ranges.data() + grid.cells.x * (cy + std::int64_t{grid.cells.y} * cz);
          for (std::size_t cx = 0; cx < cells_x; ++cx) include(target[cx], row[cx]);
        }
      }
    }
  }
  const auto bricks_along = [](std::int32_t n) { return (n >> kBrickShift) + 1; };
  grid.bricks = {bricks_along(size.x), bricks_along(size.y), bricks_along(size.z)};
  grid.brick_ranges = brick_ranges_of(voxels, size, grid.bricks);
  grid.whole = kNothing;
  for (ValueRange range : grid.ranges) include(grid.whole, range);
  return grid;
}

LabelGrid make_label_grid(const volume::LabelSet& set, Int3 size) {
  LabelGrid grid;
  if (set.empty()) return grid;
  for (const volume::LabelEntry& entry : set.table) grid.numbers.push_back(entry.number);
  const auto cells_along = [](std::int32_t n) { return (n + kCellSize - 1) >> kCellShift; };
  const auto first = [](std::int32_t cell) { return std::max(cell * kCellSize - 1, 0); };
  const auto end = [](std::int32_t cell, std::int32_t n) {
    return std::min((cell + 1) * kCellSize + 1, n);
  };
  std::unordered_map<std::bitset<256>, std::uint32_t> known;
  for (std::int32_t cz = 0; cz < cells_along(size.z); ++cz) {
    for (std::int32_t cy = 0; cy < cells_along(size.y); ++cy) {
      for (std::int32_t cx = 0; cx < cells_along(size.x); ++cx) {
        std::bitset<256> found;
        for (std::int32_t z = first(cz); z < end(cz, size.z); ++z) {
          for (std::int32_t y = first(cy); y < end(cy, size.y); ++y) {
            const std::uint8_t* row =
                set.labels.voxels.data() + size.x * (y + std::int64_t{size.y} * z);
            for (std::int32_t x = first(cx); x < end(cx, size.x); ++x) found.set(row[x]);
          }
        }
        const auto [at, is_new] =
            known.emplace(found, static_cast<std::uint32_t>(grid.sets.size()));
        if (is_new) grid.sets.push_back(found);
        grid.set_of_cell.push_back(at->second);
      }
    }
  }
  return grid;
}

}  // namespace diaphane::render
