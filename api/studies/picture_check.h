#pragma once

#include <string_view>

#include "api/studies/studies.h"

namespace diaphane::api {

/// Checks that a file is a JPEG or PNG picture that can be decoded, of at most 512 KiB and 4096 x
/// 4096 pixels, and removes its metadata: a picture from a phone says where it was taken. Returns
/// kInvalid for any other file.
Result<CheckedPicture> check_picture(std::string_view file);

}  // namespace diaphane::api
