#include "ingest/body/cell_values.h"

#include <algorithm>
#include <limits>

namespace diaphane::ingest {

CellValues cell_values(const volume::Volume& volume, const volume::Labels& labels) {
  CellValues values;
  values.cells = make_cells(volume, 0);
  const std::size_t count = values.cells.count();
  values.least.assign(count, std::numeric_limits<std::int16_t>::max());
  values.most.assign(count, std::numeric_limits<std::int16_t>::min());
  values.body.assign(count, 1);
  for_cell_runs(values.cells, volume.header.size,
                [&](std::size_t cell, std::size_t voxel, std::size_t n) {
                  std::int16_t least = values.least[cell], most = values.most[cell];
                  bool body = true;
                  for (std::size_t i = voxel; i < voxel + n; ++i) {
                    least = std::min(least, volume.voxels[i]);
                    most = std::max(most, volume.voxels[i]);
                    body = body && volume::is_body(labels.voxels[i]);
                  }
                  values.least[cell] = least;
                  values.most[cell] = most;
                  if (!body) values.body[cell] = 0;
                });
  return values;
}

CellMask without_small(const Cells& cells, const CellMask& mask, double ml) {
  CellMask kept(mask.size());
  for (const CellList& piece : components(cells, mask).members) {
    if (static_cast<double>(piece.size()) * cells.cell_volume() < 1000 * ml) continue;
    for (const std::uint32_t cell : piece) kept[cell] = 1;
  }
  return kept;
}

CellMask without_small(const Cells& cells, const std::vector<std::uint16_t>& voxels,
                       double voxel_ml, double ml) {
  CellMask mask(voxels.size()), kept(voxels.size());
  std::transform(voxels.begin(), voxels.end(), mask.begin(),
                 [](std::uint16_t n) { return n > 0 ? 1 : 0; });
  for (const CellList& piece : components(cells, mask).members) {
    double sum = 0;
    for (const std::uint32_t cell : piece) sum += voxels[cell];
    if (sum * voxel_ml < ml) continue;
    for (const std::uint32_t cell : piece) kept[cell] = 1;
  }
  return kept;
}

}  // namespace diaphane::ingest
