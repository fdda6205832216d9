#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane {

/// Returns a random identifier from the kernel's generator: a lower-case UUID version 4 (RFC 9562).
std::string new_id();
/// Returns whether `text` has the form of new_id(). Every ID from outside must be checked before it
/// becomes part of a path, a key or a query.
bool is_id(std::string_view text);
/// Returns `bytes` random bytes from the kernel as lower-case hexadecimal, for tickets and tokens.
std::string random_hex(std::size_t bytes);

}  // namespace diaphane
