#pragma once

#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"

// Checks a browser's order for a file (docs/adr/0031) against its limits.

namespace diaphane::render {

/// Appends a key view, whose index must be the next one. Index 0 starts a new list and always
/// clears `keys`. Otherwise `keys` is unchanged if it fails with kInvalid.
Result<void> note_key_view(std::vector<diaphane::v1::Scene>& keys,
                           const diaphane::v1::KeyView& view);

/// Fails with kInvalid and the name of what is wrong with the order or with its scene.
Result<void> check_picture(const diaphane::v1::LargePicture& picture,
                           const std::vector<diaphane::v1::Scene>& keys);

}  // namespace diaphane::render
