#include "ingest/body/air_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace diaphane::ingest {
namespace {

using volume::Label;

// Hounsfield units. The tissue of lungs has a mean between kDeepestLung and kDensestLung, and the
// gas in airways and bowel has less.
constexpr int kAiry = -500, kDeepestLung = -935, kDensestLung = -600;
constexpr std::array<int, 3> kGas{-930, -950, -970};  // the first that does not leak into the lungs
constexpr int kAirwayWall = -880;
constexpr int kLeastOfTissue = -960;  // beside gas, in which single voxels have less
constexpr double kLeastLung = 60, kLeastLungs = 200, kLeastGas = 2;  // ml
constexpr double kLeastAirway = 5, kMostAirway = 150;                // ml

CellMask body_cells_below(const CellValues& values, int limit) {
  CellMask mask(values.body.size());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask[i] = values.body[i] && values.cells.mean[i] < limit ? 1 : 0;
  }
  return mask;
}

double mean_of(const Cells& cells, const CellList& piece) {
  double sum = 0;
  for (const std::uint32_t cell : piece) sum += cells.mean[cell];
  return sum / static_cast<double>(piece.size());
}

/// Returns the cells of the lungs, or none if the scan does not show them. `gas`: cells with gas of
/// the airways or the bowel, and those around it.
CellMask find_lungs(const CellValues& values, const CellMask& gas) {
  const Cells& cells = values.cells;
  CellMask airy = body_cells_below(values, kAiry);
  for (std::size_t i = 0; i < airy.size(); ++i) airy[i] &= gas[i] ^ 1;
  CellMask lungs(airy.size());
  double ml = 0;
  for (const CellList& piece : components(cells, airy).members) {
    const double piece_ml = static_cast<double>(piece.size()) * cells.cell_volume() / 1000;
    const double mean = mean_of(cells, piece);
    if (piece_ml < kLeastLung || mean < kDeepestLung || mean > kDensestLung) continue;
    ml += piece_ml;
    for (const std::uint32_t cell : piece) lungs[cell] = 1;
  }
  if (ml < kLeastLungs) lungs.assign(lungs.size(), 0);
  return lungs;
}

/// The extent of cells along the axes of the patient, in cells.
struct Range {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  void add(const std::array<int, 3>& at) {
    for (std::size_t p = 0; p < 3; ++p) {
      low[p] = std::min(low[p], at[p]);
      high[p] = std::max(high[p], at[p]);
    }
  }
};

Range range_of(const Cells& cells, const CellMask& mask) {
  Range range;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i]) range.add(cells.place(i));
  }
  return range;
}

/// Returns whether gas is a windpipe that enters the lungs from above, between both sides: it
/// touches lungs, and its upper part is a tube near the middle. The gas of stomach and bowel is
/// lower or at a side.
bool is_windpipe(const Cells& cells, const CellList& piece, const CellMask& near_lungs,
                 const Range& lungs) {
  constexpr double kTopMm = 30, kMostAside = 40, kLeastArea = 40, kMostArea = 700, kLeastMm = 40;
  const double ml = static_cast<double>(piece.size()) * cells.cell_volume() / 1000;
  if (ml < kLeastAirway || ml > kMostAirway) return false;
  Range range;
  std::size_t touching = 0;
  for (const std::uint32_t cell : piece) {
    range.add(cells.place(cell));
    touching += near_lungs[cell];
  }
  const int middle = (lungs.low[2] + lungs.high[2]) / 2;
  const double height = (range.high[2] + 1 - range.low[2]) * cells.mm[2];
  if (touching == 0 || range.high[2] <= middle || height < kLeastMm) return false;
  const int levels = std::max(1, static_cast<int>(kTopMm / cells.mm[2]));
  double n = 0, x = 0;
  for (const std::uint32_t cell : piece) {
    const auto at = cells.place(cell);
    if (at[2] <= range.high[2] - levels) continue;
    n += 1;
    x += at[0];
  }
  const double aside = std::abs(x / n - (lungs.low[0] + lungs.high[0]) / 2.0) * cells.mm[0];
  const double area = n * cells.mm[0] * cells.mm[1] / levels;
  return aside <= kMostAside && area >= kLeastArea && area <= kMostArea;
}

/// Returns the cells of the windpipe and the bronchi, or none.
CellMask find_airways(const CellValues& values, const CellMask& lungs) {
  const Cells& cells = values.cells;
  const Range range = range_of(cells, lungs);
  const CellMask near_lungs = dilated(cells, lungs, {3, 3, 3});
  for (const int gas : kGas) {
    CellList best;
    for (CellList& piece : components(cells, body_cells_below(values, gas)).members) {
      if (piece.size() > best.size() && is_windpipe(cells, piece, near_lungs, range)) {
        best = std::move(piece);
      }
    }
    if (best.empty()) continue;
    CellMask airways(lungs.size());
    for (const std::uint32_t cell : best) airways[cell] = 1;
    return airways;
  }
  return CellMask(lungs.size());
}

}  // namespace

CellMask mark_air_parts(const volume::Volume& volume, const CellValues& values,
                        volume::Labels& labels) {
  const Cells& cells = values.cells;
  // The cells around gas are gas and tissue in part.
  const CellMask gas =
      dilated(cells, without_small(cells, body_cells_below(values, kGas[0]), kLeastGas), {1, 1, 1});
  CellMask lungs = find_lungs(values, gas);
  if (count(lungs) == 0) return lungs;
  const CellMask airways = find_airways(values, lungs);
  const CellMask near_lungs = dilated(cells, lungs, {1, 1, 1});
  const CellMask near_airways = dilated(cells, airways, {1, 1, 1});
  constexpr int kAnything = -32768;
  const auto mark = [&](std::size_t voxel, std::size_t n, int low, int limit, Label label) {
    for (std::size_t i = voxel; i < voxel + n; ++i) {
      if (volume.voxels[i] >= low && volume.voxels[i] < limit &&
          labels.voxels[i] == static_cast<std::uint8_t>(Label::kBody)) {
        labels.voxels[i] = static_cast<std::uint8_t>(label);
      }
    }
  };
  for_cell_runs(cells, volume.header.size, [&](std::size_t cell, std::size_t voxel, std::size_t n) {
    if (airways[cell]) {
      mark(voxel, n, kAnything, kAiry, Label::kAirway);
    } else if (near_airways[cell] && !lungs[cell]) {
      mark(voxel, n, kAnything, kAirwayWall, Label::kAirway);
    }
    if (!airways[cell] && near_lungs[cell]) {
      mark(voxel, n, gas[cell] ? kLeastOfTissue : kAnything, kAiry, Label::kLung);
    }
  });
  for (std::size_t i = 0; i < lungs.size(); ++i) lungs[i] |= airways[i];
  return dilated(cells, std::move(lungs), {2, 2, 2});
}

}  // namespace diaphane::ingest
