#include "ingest/head/coarse.h"

#include <algorithm>
#include <cmath>

namespace diaphane::ingest {
namespace {

/// Calls `visit` with each of the up to four neighbours of a cell.
template <typename Visit>
void neighbours(int cell, int width, int height, Visit visit) {
  const int x = cell % width, y = cell / width;
  if (x > 0) visit(cell - 1);
  if (x + 1 < width) visit(cell + 1);
  if (y > 0) visit(cell - width);
  if (y + 1 < height) visit(cell + width);
}

/// Flood-fills open cells without a mark from `start` and returns their number.
std::size_t fill(const Mask& open, Mask& marked, std::uint8_t mark, int start, int width,
                 int height) {
  if (!open[static_cast<std::size_t>(start)] || marked[static_cast<std::size_t>(start)]) return 0;
  std::vector<int> waiting{start};
  marked[static_cast<std::size_t>(start)] = mark;
  std::size_t count = 0;
  while (!waiting.empty()) {
    const int cell = waiting.back();
    waiting.pop_back();
    ++count;
    neighbours(cell, width, height, [&](int next) {
      const auto n = static_cast<std::size_t>(next);
      if (!open[n] || marked[n]) return;
      marked[n] = mark;
      waiting.push_back(next);
    });
  }
  return count;
}

}  // namespace

WorldBox world_box(const volume::Header& header) {
  WorldBox box;
  for (std::size_t p = 0; p < 3; ++p) {
    double half = 0;
    for (std::size_t v = 0; v < 3; ++v) {
      half += std::abs(header.direction[3 * p + v]) * header.spacing[v] * header.size[v] / 2;
    }
    box.low[p] = -half;
    box.high[p] = half;
  }
  return box;
}

Coarse coarse_of(const volume::Volume& volume) {
  const volume::Header& header = volume.header;
  const WorldBox box = world_box(header);
  Coarse coarse;
  coarse.low = box.low;
  for (std::size_t i = 0; i < 3; ++i) {
    coarse.size[i] = std::max(1, static_cast<int>((box.high[i] - box.low[i]) / Coarse::kCellMm));
  }
  const std::size_t cells = coarse.cells_of_level() * static_cast<std::size_t>(coarse.size[2]);
  coarse.mean.assign(cells, Coarse::kNothing);
  coarse.most.assign(cells, Coarse::kNothing);

  const auto value = [&](const std::array<double, 3>& place) -> float {
    std::array<std::int64_t, 3> index{};
    for (std::size_t v = 0; v < 3; ++v) {
      double along = 0;
      for (std::size_t p = 0; p < 3; ++p) along += header.direction[3 * p + v] * place[p];
      index[v] =
          static_cast<std::int64_t>(std::floor(along / header.spacing[v] + header.size[v] / 2.0));
      if (index[v] < 0 || index[v] >= std::int64_t{header.size[v]}) return Coarse::kNothing;
    }
    const auto at = static_cast<std::size_t>(
        index[0] +
        std::int64_t{header.size[0]} * (index[1] + std::int64_t{header.size[1]} * index[2]));
    return volume.voxels[at];
  };
  for (int z = 0; z < coarse.size[2]; ++z) {
    for (int y = 0; y < coarse.size[1]; ++y) {
      for (int x = 0; x < coarse.size[0]; ++x) {
        const auto middle = coarse.place(x, y, z);
        float sum = 0, most = Coarse::kNothing;
        int inside = 0;
        for (int corner = 0; corner < 8; ++corner) {
          constexpr double kQuarter = Coarse::kCellMm / 4;
          const float v = value({middle[0] + (corner & 1 ? kQuarter : -kQuarter),
                                 middle[1] + (corner & 2 ? kQuarter : -kQuarter),
                                 middle[2] + (corner & 4 ? kQuarter : -kQuarter)});
          if (v == Coarse::kNothing) continue;
          sum += v;
          most = std::max(most, v);
          ++inside;
        }
        if (inside == 0) continue;
        coarse.mean[coarse.at(x, y, z)] = sum / static_cast<float>(inside);
        coarse.most[coarse.at(x, y, z)] = most;
      }
    }
  }
  return coarse;
}

Mask reached_from_border(const Mask& open, int width, int height) {
  Mask reached(open.size(), 0);
  for (int x = 0; x < width; ++x) {
    fill(open, reached, 1, x, width, height);
    fill(open, reached, 1, x + width * (height - 1), width, height);
  }
  for (int y = 0; y < height; ++y) {
    fill(open, reached, 1, width * y, width, height);
    fill(open, reached, 1, width * y + width - 1, width, height);
  }
  return reached;
}

std::size_t keep_largest(Mask& mask, int width, int height) {
  Mask seen(mask.size(), 0);
  std::size_t most = 0;
  int best = -1;
  for (int cell = 0; cell < width * height; ++cell) {
    const std::size_t count = fill(mask, seen, 1, cell, width, height);
    if (count > most) {
      most = count;
      best = cell;
    }
  }
  Mask largest(mask.size(), 0);
  if (best >= 0) fill(mask, largest, 1, best, width, height);
  mask = std::move(largest);
  return most;
}

}  // namespace diaphane::ingest
