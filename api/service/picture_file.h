#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// Writes under a name of its own and renames, making the folder: a reader never sees half a
/// picture. kUnavailable.
Result<void> write_picture(const std::string& path, std::string_view bytes);

}  // namespace diaphane::api
