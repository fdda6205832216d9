#pragma once

#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Labels bone, lungs, airways and vessels with contrast medium among the voxels of the body in a
/// CT scan in Hounsfield units. If in doubt, a voxel stays Label::kBody. `labels`: of label_body()
/// for this volume, which holds one phase.
void mark_structures(const volume::Volume& volume, volume::Labels& labels);

}  // namespace diaphane::ingest
