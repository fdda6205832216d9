#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// Writes an image file and creates its folder. The file is written under a temporary name and then
/// renamed, so that a reader never sees half an image. Returns kUnavailable on failure.
Result<void> write_picture(const std::string& path, std::string_view bytes);

}  // namespace diaphane::api
