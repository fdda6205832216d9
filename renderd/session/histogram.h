#pragma once

#include "api/proto/stream.pb.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Returns a histogram of every n-th voxel, of at most four million voxels. It has up to 256 bins,
/// each at least 1 wide, so that no bin lies empty between two integers. Values outside the
/// header's minimum and maximum are padding and are excluded.
diaphane::v1::Histogram histogram_of(const volume::Volume& volume);

}  // namespace diaphane::render
