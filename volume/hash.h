#pragma once

#include <cstddef>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// "blake2b:" and the hexadecimal BLAKE2b-256 (RFC 7693) of the bytes.
/// kUnsupported in a build without libsodium.
Result<std::string> content_hash(const void* data, std::size_t bytes);

}  // namespace diaphane::volume
