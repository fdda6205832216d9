#pragma once

#include "ingest/body/cell_values.h"

namespace diaphane::ingest {

/// Labels lungs and, if there are lungs, the airways that lead to them. Air of the bowel, the
/// sinuses and the throat gets no label. Returns the cells of both, with those around them.
CellMask mark_air_parts(const volume::Volume& volume, const CellValues& values,
                        volume::Labels& labels);

}  // namespace diaphane::ingest
