#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane {

/// A random identifier as a lower-case UUID version 4 (RFC 9562), from the kernel's generator.
std::string new_id();
/// Returns true only for the form that new_id() returns. Check every ID from outside with it before
/// it becomes part of a path, a key or a query.
bool is_id(std::string_view text);
/// Returns `bytes` random bytes from the kernel as lower-case hexadecimal, for tickets and tokens.
std::string random_hex(std::size_t bytes);

}  // namespace diaphane
