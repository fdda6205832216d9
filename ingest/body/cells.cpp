#include "ingest/body/cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace diaphane::ingest {
namespace {

constexpr int kMostVoxelsPerCell = 16;  // limit per axis, so that sums of a cell fit in 32 bits

/// Assigns to each patient axis the nearest voxel axis, and each voxel axis only once.
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
    const int per = static_cast<int>(std::clamp(std::round(Cells::kCellMm / header.spacing[v]), 1.0,
                                                double{kMostVoxelsPerCell}));
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

/// Calls `combine(a, b, n)` for blocks of n consecutive cells from `a` and from `b`, which lie
/// `shift` apart along `axis`. The compiler vectorises such blocks.
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

/// A flood fill from the border of an axial level over the cells that are not in `mask`.
class LevelFlood {
 public:
  LevelFlood(const std::uint8_t* mask, int width, int height, Border border)
      : mask_(mask), width_(width), height_(height), border_(border), reached_(area(), 0) {}

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
  /// Starts the fill at the gaps of one edge, except those that `border_` closes.
  void edge(int begin, int step, int n) {
    for (int i = 0; i < n;) {
      int stop = i;
      while (stop < n && open(begin + stop * step)) ++stop;
      const bool closed = border_ == Border::kClosed && i > 0 && stop < n && 2 * (stop - i) < n;
      for (; i < stop; ++i) {
        if (!closed) visit(begin + i * step);
      }
      ++i;
    }
  }

  const std::uint8_t* mask_;
  int width_, height_;
  Border border_;
  CellMask reached_;
  std::vector<int> waiting_;
};

/// The runs of consecutive cells of a mask along x, joined to components by a union-find.
class Runs {
 public:
  Runs(const Cells& cells, const CellMask& mask)
      : width_(static_cast<std::size_t>(cells.size[0])), height_(cells.size[1]) {
    const std::size_t rows = cells.count() / width_;
    for (std::size_t row = 0; row < rows; ++row) {
      first_.push_back(runs_.size());
      const std::size_t stop = (row + 1) * width_;
      for (std::size_t i = row * width_; i < stop; ++i) {
        if (!mask[i]) continue;
        const std::size_t begin = i;
        while (i < stop && mask[i]) ++i;
        runs_.push_back({begin, i, runs_.size()});
      }
    }
    first_.push_back(runs_.size());
  }

  std::size_t size() const { return runs_.size(); }
  std::size_t begin(std::size_t run) const { return runs_[run].begin; }
  std::size_t end(std::size_t run) const { return runs_[run].end; }

  std::size_t root(std::size_t run) {
    while (runs_[run].parent != run) {
      runs_[run].parent = runs_[runs_[run].parent].parent;
      run = runs_[run].parent;
    }
    return run;
  }

  /// Joins each row with the four neighbouring rows before it.
  void join() {
    const auto height = static_cast<std::size_t>(height_);
    for (std::size_t row = 0; row + 1 < first_.size(); ++row) {
      const std::size_t y = row % height;
      if (y > 0) join_rows(row, row - 1);
      if (row < height) continue;
      join_rows(row, row - height);
      if (y > 0) join_rows(row, row - height - 1);
      if (y + 1 < height) join_rows(row, row - height + 1);
    }
  }

 private:
  struct Run {
    std::size_t begin, end, parent;
  };

  void join_rows(std::size_t row, std::size_t other) {
    const std::size_t shift = (row - other) * width_;
    std::size_t j = first_[other];
    for (std::size_t i = first_[row]; i < first_[row + 1]; ++i) {
      while (j < first_[other + 1] && runs_[j].end + shift < runs_[i].begin) ++j;
      for (std::size_t k = j; k < first_[other + 1] && runs_[k].begin + shift <= runs_[i].end;
           ++k) {
        const std::size_t a = root(i), b = root(k);
        runs_[std::max(a, b)].parent = std::min(a, b);
      }
    }
  }

  std::size_t width_;
  int height_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_;  // first run of each row
};

}  // namespace

void or_into(std::uint8_t* to, const std::uint8_t* from, std::size_t n) {
  std::size_t i = 0;
  for (std::uint64_t a = 0, b = 0; i + sizeof a <= n; i += sizeof a) {
    std::memcpy(&a, to + i, sizeof a);
    std::memcpy(&b, from + i, sizeof b);
    a |= b;
    std::memcpy(to + i, &a, sizeof a);
  }
  for (; i < n; ++i) to[i] = static_cast<std::uint8_t>(to[i] | from[i]);
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
  std::vector<std::size_t> starts;  // first voxel of each cell in a row of voxels
  for (std::size_t x = 0; x < size[0]; ++x) {
    if (x == 0 || cells.offsets[0][x] != cells.offsets[0][x - 1]) starts.push_back(x);
  }
  starts.push_back(size[0]);
  const std::int16_t* row = volume.voxels.data();
  for (std::size_t z = 0; z < size[2]; ++z) {
    for (std::size_t y = 0; y < size[1]; ++y, row += size[0]) {
      const std::size_t base = cells.offsets[1][y] + cells.offsets[2][z];
      for (std::size_t r = 0; r + 1 < starts.size(); ++r) {
        std::int32_t s = 0, a = 0;
        for (std::size_t x = starts[r]; x < starts[r + 1]; ++x) {
          s += row[x];
          a += row[x] >= threshold ? 1 : 0;
        }
        const std::size_t cell = base + cells.offsets[0][starts[r]];
        sum[cell] += s;
        above[cell] = static_cast<std::uint16_t>(above[cell] + a);
        voxels[cell] = static_cast<std::uint16_t>(voxels[cell] + starts[r + 1] - starts[r]);
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
  CellMask before(mask.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Each step adds the mask shifted to both sides by at most its reach, which doubles the reach.
    for (int reach = 0; reach < radius[axis];) {
      const int shift = std::min(std::max(1, reach), radius[axis] - reach);
      std::copy(mask.begin(), mask.end(), before.begin());
      shifted(cells, axis, shift, [&](std::size_t a, std::size_t b, std::size_t n) {
        or_into(mask.data() + a, before.data() + b, n);
        or_into(mask.data() + b, before.data() + a, n);
      });
      reach += shift;
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

CellMask filled(const Cells& cells, const CellMask& mask, Border border) {
  CellMask full = mask;
  for (std::size_t begin = 0; begin < cells.count(); begin += cells.level()) {
    LevelFlood flood(mask.data() + begin, cells.size[0], cells.size[1], border);
    const CellMask& reached = flood.from_border();
    for (std::size_t i = 0; i < reached.size(); ++i) full[begin + i] = reached[i] ? 0 : 1;
  }
  return full;
}

Components components(const Cells& cells, const CellMask& mask) {
  Runs runs(cells, mask);
  runs.join();
  Components found{std::vector<std::int32_t>(cells.count(), -1), {}};
  std::vector<std::int32_t> label_of(runs.size(), -1);  // label of a component, by its root run
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::int32_t& label = label_of[runs.root(i)];
    if (label < 0) {
      label = static_cast<std::int32_t>(sizes.size());
      sizes.push_back(0);
    }
    sizes[static_cast<std::size_t>(label)] += runs.end(i) - runs.begin(i);
  }
  found.members.resize(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) found.members[i].reserve(sizes[i]);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::int32_t label = label_of[runs.root(i)];
    auto& members = found.members[static_cast<std::size_t>(label)];
    for (std::size_t cell = runs.begin(i); cell < runs.end(i); ++cell) {
      found.label[cell] = label;
      members.push_back(static_cast<std::uint32_t>(cell));
    }
  }
  return found;
}

std::size_t count(const CellMask& mask) {
  return std::accumulate(mask.begin(), mask.end(), std::size_t{0});
}

}  // namespace diaphane::ingest
