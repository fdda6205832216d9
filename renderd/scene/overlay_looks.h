#pragma once

#include <vector>

#include "api/proto/scene.pb.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Returns the built-in looks of a second scan over the first, the default first:
/// - "hot" for PET and other scans that may show uptake or activity: what is bright glows from red
/// to
///   white;
/// - "bone" for a CT over another modality;
/// - "tint": its own surface, in a colour that tells it from the first scan;
/// - "same": its own surface, in its usual colours.
std::vector<diaphane::v1::OverlayLook> overlay_looks(const volume::Header& first,
                                                     const volume::Header& second);

}  // namespace diaphane::render
