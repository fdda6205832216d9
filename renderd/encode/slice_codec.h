#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace diaphane::render {

/// Encodes values as the bytes of ExactSlice.data (api/proto/stream.proto). Returns kInternal if
/// zlib fails.
Result<std::string> code_slice(std::span<const std::int16_t> values);

}  // namespace diaphane::render
