#pragma once

#include "api/proto/scene.pb.h"
#include "volume/region.h"

namespace diaphane::render {

/// Returns the voxels whose centres a clip keeps. Precondition: the clip has passed check_scene.
volume::KeptVoxels kept_by(const volume::Header& header, const diaphane::v1::Clip& clip);

}  // namespace diaphane::render
