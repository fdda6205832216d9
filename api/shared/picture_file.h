#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// Creates the folder, writes to a temporary name and renames the file, so that a reader never sees
/// half an image. Returns kUnavailable on failure.
Result<void> write_picture(const std::string& path, std::string_view bytes);

}  // namespace diaphane::api
