#include "ingest/body/cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace diaphane::ingest {
namespace {

constexpr int kMostVoxelsPerCell = 16;  // along one axis; sums of a cell then fit in 32 bits

/// Chooses for each patient axis the voxel axis that is nearest, each once.
void choose_axes(const volume::Header& header, Cells& cells) {
  std::array<std::size_t, 3> order{0, 1, 2};
  double best = -1;
  do {
    double sum = 0;
    for (std::size_t p = 0; p < 3; ++p) sum += std::abs(header.direction[3 * p + order[p]]);
    if (sum <= best + 1e-9) continue;
    best = sum;
    cells.axis = order;
  } while (std::next_permutation(order.begin(), order.end()));
  for (std::size_t p = 0; p < 3; ++p) {
    cells.flipped[p] = header.direction[3 * p + cells.axis[p]] < 0;
  }
}

void lay_out(const volume::Header& header, Cells& cells) {
  choose_axes(header, cells);
  std::size_t stride = 1;
  for (std::size_t p = 0; p < 3; ++p) {
    const std::size_t v = cells.axis[p];
    const auto n = static_cast<int>(header.size[v]);
    const int per = static_cast<int>(
        std::clamp(std::round(Cells::kCellMm / header.spacing[v]), 1.0, double{kMostVoxelsPerCell}));
    cells.voxels_per_cell[p] = per;
    cells.size[p] = (n + per - 1) / per;
    cells.mm[p] = per * header.spacing[v];
    cells.offsets[v].resize(header.size[v]);
    for (int i = 0; i < n; ++i) {
      const int along = (cells.flipped[p] ? n - 1 - i : i) / per;
      cells.offsets[v][static_cast<std::size_t>(i)] = static_cast<std::size_t>(along) * stride;
    }
    stride *= static_cast<std::size_t>(cells.size[p]);
  }
  cells.matter.resize(stride);
  cells.mean.resize(stride);
}

/// Calls `combine(to, from)` on every pair of cells that lie `shift` apart along `axis`, in blocks
/// of consecutive cells, which the compiler vectorises.
template <typename Combine>
void shifted(const Cells& cells, std::size_t axis, int shift, Combine combine) {
  std::size_t stride = 1;
  for (std::size_t p = 0; p < axis; ++p) stride *= static_cast<std::size_t>(cells.size[p]);
  const std::size_t block = stride * static_cast<std::size_t>(cells.size[axis]);
  const std::size_t by = stride * static_cast<std::size_t>(shift);
  if (by >= block) return;
  for (std::size_t begin = 0; begin < cells.count(); begin += block) {
    combine(begin, begin + by, block - by);
  }
}

/// Marks what can be reached over cells of a level that are not in `mask`.
class LevelFlood {
 public:
  LevelFlood(const std::uint8_t* mask, int width, int height)
      : mask_(mask), width_(width), height_(height), reached_(area(), 0) {}

  const CellMask& from_border() {
    edge(0, 1, width_);
    edge(width_ * (height_ - 1), 1, width_);
    edge(0, width_, height_);
    edge(width_ - 1, width_, height_);
    while (!waiting_.empty()) {
      const int cell = waiting_.back();
      waiting_.pop_back();
      const int x = cell % width_, y = cell / width_;
      if (x > 0) visit(cell - 1);
      if (x + 1 < width_) visit(cell + 1);
      if (y > 0) visit(cell - width_);
      if (y + 1 < height_) visit(cell + width_);
    }
    return reached_;
  }

 private:
  std::size_t area() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  bool open(int cell) const { return mask_[cell] == 0; }
  void visit(int cell) {
    auto& reached = reached_[static_cast<std::size_t>(cell)];
    if (reached || !open(cell)) return;
    reached = 1;
    waiting_.push_back(cell);
  }
  /// Starts from the gaps of one edge, except for short ones between two parts of the mask.
  void edge(int begin, int step, int n) {
    for (int i = 0; i < n;) {
      int stop = i;
      while (stop < n && open(begin + stop * step)) ++stop;
      const bool closed = i > 0 && stop < n && 2 * (stop - i) < n;
      for (; i < stop; ++i) {
        if (!closed) visit(begin + i * step);
      }
      ++i;
    }
  }

  const std::uint8_t* mask_;
  int width_, height_;
  CellMask reached_;
  std::vector<int> waiting_;
};

}  // namespace

void or_into(std::uint8_t* to, const std::uint8_t* from, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<std::uint8_t>(to[i] | from[i]);
}

std::array<int, 3> Cells::radius(double mm_wide) const {
  std::array<int, 3> cells{};
  for (std::size_t p = 0; p < 3; ++p) {
    cells[p] = std::max(1, static_cast<int>(std::lround(mm_wide / mm[p])));
  }
  return cells;
}

Cells make_cells(const volume::Volume& volume, int threshold) {
  Cells cells;
  lay_out(volume.header, cells);
  const auto& size = volume.header.size;
  std::vector<std::int32_t> sum(cells.count(), 0);
  std::vector<std::uint16_t> above(cells.count(), 0), voxels(cells.count(), 0);
  const std::size_t* along_x = cells.offsets[0].data();
  const std::int16_t* row = volume.voxels.data();
  for (std::size_t z = 0; z < size[2]; ++z) {
    for (std::size_t y = 0; y < size[1]; ++y, row += size[0]) {
      const std::size_t base = cells.offsets[1][y] + cells.offsets[2][z];
      for (std::size_t x = 0; x < size[0];) {
        const std::size_t offset = along_x[x], begin = x;
        std::int32_t s = 0, a = 0;
        for (; x < size[0] && along_x[x] == offset; ++x) {
          s += row[x];
          a += row[x] >= threshold ? 1 : 0;
        }
        sum[base + offset] += s;
        above[base + offset] = static_cast<std::uint16_t>(above[base + offset] + a);
        voxels[base + offset] = static_cast<std::uint16_t>(voxels[base + offset] + (x - begin));
      }
    }
  }
  for (std::size_t i = 0; i < cells.count(); ++i) {
    cells.mean[i] = static_cast<std::int16_t>(sum[i] / voxels[i]);
    cells.matter[i] = static_cast<std::uint8_t>((8 * above[i] + voxels[i] / 2) / voxels[i]);
  }
  return cells;
}

CellMask dilated(const Cells& cells, CellMask mask, const std::array<int, 3>& radius) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const CellMask before = mask;
    for (int shift = 1; shift <= radius[axis]; ++shift) {
      shifted(cells, axis, shift, [&](std::size_t a, std::size_t b, std::size_t n) {
        or_into(mask.data() + a, before.data() + b, n);
        or_into(mask.data() + b, before.data() + a, n);
      });
    }
  }
  return mask;
}

CellMask eroded(const Cells& cells, CellMask mask, const std::array<int, 3>& radius) {
  for (auto& cell : mask) cell ^= 1;
  mask = dilated(cells, std::move(mask), radius);
  for (auto& cell : mask) cell ^= 1;
  return mask;
}

CellMask grown_within(const Cells& cells, CellMask seed, const CellMask& mask, int steps) {
  for (int step = 0; step < steps; ++step) {
    seed = dilated(cells, std::move(seed), {1, 1, 1});
    for (std::size_t i = 0; i < seed.size(); ++i) seed[i] &= mask[i];
  }
  return seed;
}

CellMask filled(const Cells& cells, const CellMask& mask) {
  CellMask full = mask;
  for (std::size_t begin = 0; begin < cells.count(); begin += cells.level()) {
    LevelFlood flood(mask.data() + begin, cells.size[0], cells.size[1]);
    const CellMask& reached = flood.from_border();
    for (std::size_t i = 0; i < reached.size(); ++i) full[begin + i] = reached[i] ? 0 : 1;
  }
  return full;
}

Components components(const Cells& cells, const CellMask& mask) {
  Components found{std::vector<std::int32_t>(cells.count(), -1), {}};
  const auto& [nx, ny, nz] = cells.size;
  for (std::size_t start = 0; start < cells.count(); ++start) {
    if (!mask[start] || found.label[start] >= 0) continue;
    const auto label = static_cast<std::int32_t>(found.members.size());
    std::vector<std::size_t> members{start};
    found.label[start] = label;
    for (std::size_t next = 0; next < members.size(); ++next) {  // a queue that keeps its cells
      const auto [x, y, z] = cells.place(members[next]);
      for (int c = std::max(0, z - 1); c <= std::min(nz - 1, z + 1); ++c) {
        for (int b = std::max(0, y - 1); b <= std::min(ny - 1, y + 1); ++b) {
          for (int a = std::max(0, x - 1); a <= std::min(nx - 1, x + 1); ++a) {
            const std::size_t cell = cells.at(a, b, c);
            if (!mask[cell] || found.label[cell] >= 0) continue;
            found.label[cell] = label;
            members.push_back(cell);
          }
        }
      }
    }
    found.members.push_back(std::move(members));
  }
  return found;
}

std::size_t count(const CellMask& mask) {
  return std::accumulate(mask.begin(), mask.end(), std::size_t{0});
}

}  // namespace diaphane::ingest
