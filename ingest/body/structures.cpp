#include "ingest/body/structures.h"

#include <algorithm>
#include <vector>

#include "ingest/body/air_parts.h"
#include "ingest/body/cell_values.h"
#include "ingest/body/dense_parts.h"
#include "ingest/body/values.h"

namespace diaphane::ingest {
namespace {

/// Returns whether values from 0 are Hounsfield units of a scan from which everything but some
/// structures has been removed.
bool is_cut_out_hounsfield(const volume::Volume& volume) {
  constexpr int kMostMedian = 150, kLeastMaximum = 400;
  const volume::Header& header = volume.header;
  if (header.minimum != 0 || header.maximum < kLeastMaximum) return false;
  std::vector<std::int16_t> rest;
  std::copy_if(volume.voxels.begin(), volume.voxels.end(), std::back_inserter(rest),
               [](std::int16_t value) { return value > 0; });
  if (rest.empty() || 2 * rest.size() > volume.voxels.size()) return false;
  const auto middle = rest.begin() + static_cast<std::ptrdiff_t>(rest.size() / 2);
  std::nth_element(rest.begin(), middle, rest.end());
  return *middle <= kMostMedian;
}

}  // namespace

void mark_structures(const volume::Volume& volume, volume::Labels& labels) {
  if (volume.header.modality != volume::Modality::kCt || labels.voxels.empty()) return;
  if (!is_hounsfield(volume.header) && !is_cut_out_hounsfield(volume)) return;
  const CellValues values = cell_values(volume, labels);
  constexpr int kFewestCells = 8;
  const auto& size = values.cells.size;
  if (*std::min_element(size.begin(), size.end()) < kFewestCells) return;
  const CellMask air = mark_air_parts(volume, values, labels);
  mark_dense_parts(volume, values, air, labels);
}

}  // namespace diaphane::ingest
