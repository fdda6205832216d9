#pragma once

#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"

// What a browser says of a file that it wants to take away (docs/adr/0031), held against its
// bounds.

namespace diaphane::render {

/// The next of the key views, or the first of new ones. kInvalid: then `keys` are as they were but
/// for a first one, which forgets them whatever it is.
Result<void> note_key_view(std::vector<diaphane::v1::Scene>& keys,
                           const diaphane::v1::KeyView& view);

/// kInvalid names what is wrong with the order, or with what is to be seen.
Result<void> check_picture(const diaphane::v1::LargePicture& picture,
                           const std::vector<diaphane::v1::Scene>& keys);

}  // namespace diaphane::render
