#pragma once

#include "ingest/body/cell_values.h"

namespace diaphane::ingest {

/// Labels bone, and vessels with contrast medium if a large piece of them is evident. `air`: cells
/// of lungs and airways.
void mark_dense_parts(const volume::Volume& volume, const CellValues& values, const CellMask& air,
                      volume::Labels& labels);

}  // namespace diaphane::ingest
