#pragma once

#include <vector>

#include "renderd/kernel/views.h"
#include "renderd/scene/grid.h"

namespace diaphane::render {

/// What the exact walk needs of a transfer function, for one volume.
struct ExactTables {
  std::vector<ExtinctionPiece> pieces;
  std::vector<std::uint16_t> piece_of;  ///< ExactView
  std::int32_t first_value = 0;
  /// For each voxel value from `first_value` on: up to which value from there on the extinction is
  /// 0; a smaller value where it is not 0 even there. A brick is empty when its values end by then.
  std::vector<std::int32_t> clear_until;
  std::vector<std::uint8_t> skips;  ///< make_skips()
  std::uint64_t occupied = 0;       ///< bricks in which something may be
};

/// Pieces of a table of `count` nodes, `scale` a unit of value, from `first` on, that is linear
/// between its nodes: nodes in line are joined. The relative error of a joined node is below 1e-6.
std::vector<ExtinctionPiece> join_pieces(const float* extinction, std::int32_t count, double scale,
                                         double first);

/// `extinction` and so on as in TransferView.
ExactTables make_exact_tables(const float* extinction, std::int32_t count, double scale,
                              const ValueGrid& grid);

/// ExactView::skips, a BrickArray for each octant, from which bricks are occupied, x fastest.
std::vector<std::uint8_t> make_skips(const std::vector<std::uint8_t>& occupied, Int3 bricks);

}  // namespace diaphane::render
