#pragma once

#include "api/proto/stream.pb.h"
#include "volume/volume.h"

namespace diaphane::render {

/// How often values occur, by every n-th voxel, four million at most: up to 256 bins, none narrower
/// than 1, so that none stands empty between two integers. What lies outside of the header's
/// minimum and maximum is padding, and left out.
diaphane::v1::Histogram histogram_of(const volume::Volume& volume);

}  // namespace diaphane::render
