#pragma once

#include <vector>

#include "renderd/kernel/views.h"
#include "renderd/scene/grid.h"

namespace diaphane::render {

/// The transfer function as the exact walk needs it, for one volume.
struct ExactTables {
  std::vector<ExtinctionPiece> pieces;
  std::vector<std::uint16_t> piece_of;  ///< as ExactView::piece_of
  std::int32_t first_value = 0;
  /// For each voxel value from `first_value` on: the largest value up to which the extinction is 0
  /// from there on, or a smaller value if it is not 0 at the value itself. A brick is empty if its
  /// largest value does not exceed the entry of its smallest one.
  std::vector<std::int32_t> clear_until;
  std::vector<std::uint8_t> skips;  ///< from make_skips()
  std::uint64_t occupied = 0;       ///< number of bricks that may contain matter
};

/// Returns the linear pieces of a table that is linear between its `count` nodes. The nodes are
/// `scale` per unit of value and start at the value `first`. Nodes in line are joined, which
/// changes the table at a node by a relative error below 1e-6.
std::vector<ExtinctionPiece> join_pieces(const float* extinction, std::int32_t count, double scale,
                                         double first);

/// Makes the tables from an extinction table whose parameters are those of TransferView.
ExactTables make_exact_tables(const float* extinction, std::int32_t count, double scale,
                              const ValueGrid& grid);

/// Returns ExactView::skips, one BrickArray per octant. `occupied` says which bricks contain
/// matter, x fastest.
std::vector<std::uint8_t> make_skips(const std::vector<std::uint8_t>& occupied, Int3 bricks);

}  // namespace diaphane::render
