#include "renderd/scene/exact_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render {
namespace {

constexpr std::size_t kMostPieces = 65535;  // piece numbers have 16 bits

/// The slopes of all lines from one node that pass another node within its tolerance.
struct Cone {
  double low = -std::numeric_limits<double>::infinity(),
         high = std::numeric_limits<double>::infinity();

  bool holds(double slope) const { return slope >= low && slope <= high; }
  void narrow(double a, double b) {
    low = std::max(low, a);
    high = std::min(high, b);
  }
};

std::vector<std::int32_t> clear_ranges(const std::vector<ExtinctionPiece>& pieces,
                                       bool last_is_not_zero, ValueRange full_range) {
  std::vector<std::int32_t> until(
      static_cast<std::size_t>(full_range.maximum - full_range.minimum + 1));
  std::size_t p = pieces.size();
  // The first piece from this value on that is not 0 everywhere.
  const ExtinctionPiece* nearest = nullptr;
  for (std::int32_t value = full_range.maximum; value >= full_range.minimum; --value) {
    const auto v = static_cast<float>(value);
    for (; p > 0 && pieces[p - 1].end > v; --p) {
      if (pieces[p - 1].extinction > 0 || pieces[p - 1].slope != 0) nearest = &pieces[p - 1];
    }
    std::int32_t clear =
        last_is_not_zero && value == full_range.maximum ? value - 1 : full_range.maximum;
    if (nearest != nullptr && nearest->begin > v) {
      clear = static_cast<std::int32_t>(std::floor(nearest->begin));
    } else if (nearest != nullptr) {
      clear = nearest->begin == v && nearest->extinction == 0 ? value : value - 1;
    }
    until[static_cast<std::size_t>(value - full_range.minimum)] = clear;
  }
  return until;
}

}  // namespace

std::vector<ExtinctionPiece> join_pieces(const float* extinction, std::int32_t count, double scale,
                                         double first) {
  // The tolerance is relative to the larger end of a piece, so that a thin region beside a dense
  // one keeps its own precision and zeros stay exactly 0.
  constexpr double kTolerance = 4e-7;
  const auto value_of = [&](std::int32_t node) { return first + node / scale; };
  std::vector<ExtinctionPiece> pieces;
  std::int32_t begin = 0;
  while (begin + 1 < count) {
    Cone cone;
    std::int32_t end = begin + 1;
    const double start = extinction[begin];
    for (std::int32_t node = begin + 1; node < count; ++node) {
      const double run = value_of(node) - value_of(begin), here = extinction[node];
      if (!cone.holds((here - start) / run)) break;
      end = node;
      // The line must also be near each node relative to that node's value, so that it does not
      // lift a node off 0.
      const double most = kTolerance * std::abs(here);
      cone.narrow((here - most - start) / run, (here + most - start) / run);
    }
    const double run = value_of(end) - value_of(begin);
    const double slope = (double{extinction[end]} - start) / run;
    pieces.push_back({static_cast<float>(value_of(begin)), extinction[begin],
                      static_cast<float>(slope), static_cast<float>(value_of(end))});
    begin = end;
  }
  return pieces;
}

std::vector<std::uint8_t> make_skips(const std::vector<std::uint8_t>& occupied, Int3 bricks) {
  const std::int32_t nx = bricks.x, ny = bricks.y, nz = bricks.z;
  const BrickArray array(bricks);
  const auto count = static_cast<std::size_t>(array.count);
  std::vector<std::uint8_t> skips(8 * count, static_cast<std::uint8_t>(kOutside));
  for (int octant = 0; octant < 8; ++octant) {
    std::uint8_t* skip = skips.data() + count * static_cast<std::size_t>(octant);
    const auto towards = [octant](int bit) { return (octant >> bit & 1) != 0 ? 1 : -1; };
    const int sx = towards(0), sy = towards(1), sz = towards(2);
    // A cube of n bricks is empty if its first brick is empty and so are the seven cubes of n - 1
    // bricks beside it. Everything outside the volume is empty.
    const auto at = [&](std::int32_t x, std::int32_t y, std::int32_t z) -> int {
      return skip[array.index({x, y, z})];
    };
    for (std::int32_t k = 0; k < nz; ++k) {
      const std::int32_t z = sz > 0 ? nz - 1 - k : k;
      for (std::int32_t j = 0; j < ny; ++j) {
        const std::int32_t y = sy > 0 ? ny - 1 - j : j;
        for (std::int32_t i = 0; i < nx; ++i) {
          const std::int32_t x = sx > 0 ? nx - 1 - i : i;
          const std::int64_t brick = x + nx * (y + std::int64_t{ny} * z);
          std::uint8_t& here = skip[array.index({x, y, z})];
          here = 0;
          if (occupied[static_cast<std::size_t>(brick)] != 0) continue;
          const int least =
              std::min({at(x + sx, y, z), at(x, y + sy, z), at(x, y, z + sz), at(x + sx, y + sy, z),
                        at(x + sx, y, z + sz), at(x, y + sy, z + sz), at(x + sx, y + sy, z + sz)});
          here = static_cast<std::uint8_t>(std::min(least + 1, kOutside - 1));
        }
      }
    }
  }
  return skips;
}

ExactTables make_exact_tables(const float* extinction, std::int32_t count, double scale,
                              const ValueGrid& grid) {
  ExactTables out;
  out.first_value = grid.whole.minimum;
  out.pieces = join_pieces(extinction, count, scale, grid.whole.minimum);
  if (out.pieces.size() > kMostPieces) return ExactTables{};
  const std::int32_t values = grid.whole.maximum - grid.whole.minimum + 1;
  out.piece_of.resize(static_cast<std::size_t>(values));
  std::size_t piece = 0;
  for (std::int32_t i = 0; i < values; ++i) {
    const auto value = static_cast<float>(grid.whole.minimum + i);
    while (piece + 1 < out.pieces.size() && out.pieces[piece + 1].begin <= value) ++piece;
    out.piece_of[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(piece);
  }
  out.clear_until = clear_ranges(out.pieces, extinction[count - 1] > 0, grid.whole);
  if (grid.brick_ranges.empty()) return out;  // the ranges are on a device
  std::vector<std::uint8_t> occupied(grid.brick_ranges.size());
  for (std::size_t b = 0; b < occupied.size(); ++b) {
    const ValueRange range = grid.brick_ranges[b];
    occupied[b] = range.maximum >
                  out.clear_until[static_cast<std::size_t>(range.minimum - grid.whole.minimum)];
    out.occupied += occupied[b];
  }
  out.skips = make_skips(occupied, grid.bricks);
  return out;
}

}  // namespace diaphane::render
