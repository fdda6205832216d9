#include "renderd/scene/contrast_agent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace diaphane::render {
namespace {

constexpr double kCell = 3;  // mm
/// Hounsfield units. Blood with contrast agent has 150 to 450, and noise spreads the values.
constexpr std::int16_t kLeast = 120, kDense = 500;
constexpr double kEnough = 1000;  // mm³

struct Cell {
  std::int16_t least = std::numeric_limits<std::int16_t>::max();
  std::int16_t most = std::numeric_limits<std::int16_t>::min();
};

class Cells {
 public:
  explicit Cells(const volume::Volume& volume) {
    const volume::Header& header = volume.header;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto voxels = std::lround(kCell / header.spacing[axis]);
      edge_[axis] = static_cast<std::uint32_t>(
          std::clamp<long>(voxels, 1, static_cast<long>(header.size[axis])));
      size_[axis] = header.size[axis] / edge_[axis];  // incomplete cells at the end are left out
      cubic_mm_ *= edge_[axis] * header.spacing[axis];
    }
    cells_.resize(std::size_t{size_[0]} * size_[1] * size_[2]);
    for (std::uint32_t z = 0; z < size_[2] * edge_[2]; ++z) {
      for (std::uint32_t y = 0; y < size_[1] * edge_[1]; ++y) add_row(volume, y, z);
    }
  }

  double cubic_mm_of_contrast_agent() const {
    std::size_t found = 0;
    for (std::uint32_t z = 1; z + 1 < size_[2]; ++z) {
      for (std::uint32_t y = 1; y + 1 < size_[1]; ++y) {
        for (std::uint32_t x = 1; x + 1 < size_[0]; ++x) {
          if (at(x, y, z).least > kLeast && !beside_dense(x, y, z)) ++found;
        }
      }
    }
    return static_cast<double>(found) * cubic_mm_;
  }

 private:
  const Cell& at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return cells_[(std::size_t{z} * size_[1] + y) * size_[0] + x];
  }

  void add_row(const volume::Volume& volume, std::uint32_t y, std::uint32_t z) {
    const auto& size = volume.header.size;
    const std::int16_t* voxel = &volume.voxels[(std::size_t{z} * size[1] + y) * size[0]];
    Cell* cell = &cells_[(std::size_t{z / edge_[2]} * size_[1] + y / edge_[1]) * size_[0]];
    for (std::uint32_t x = 0; x < size_[0]; ++x, ++cell) {
      for (std::uint32_t i = 0; i < edge_[0]; ++i, ++voxel) {
        cell->least = std::min(cell->least, *voxel);
        cell->most = std::max(cell->most, *voxel);
      }
    }
  }

  bool beside_dense(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    for (std::uint32_t k = z - 1; k <= z + 1; ++k) {
      for (std::uint32_t j = y - 1; j <= y + 1; ++j) {
        for (std::uint32_t i = x - 1; i <= x + 1; ++i) {
          if (at(i, j, k).most >= kDense) return true;
        }
      }
    }
    return false;
  }

  std::array<std::uint32_t, 3> edge_{}, size_{};
  double cubic_mm_ = 1;
  std::vector<Cell> cells_;
};

}  // namespace

bool shows_contrast_agent(const volume::Volume& volume) {
  if (volume.header.modality != volume::Modality::kCt || volume.voxels.empty()) return false;
  return Cells(volume).cubic_mm_of_contrast_agent() >= kEnough;
}

}  // namespace diaphane::render
