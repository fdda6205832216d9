#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace diaphane::render {

/// Encodes values as the bytes of ExactSlice.data (api/proto/stream.proto). Returns kInternal if
/// zlib fails.
Result<std::string> code_slice(std::span<const std::int16_t> values);
/// Encodes label values as the bytes of ExactSlice.labels, which are empty if all values are 0.
/// Returns kInternal if zlib fails.
Result<std::string> code_labels(std::span<const std::uint8_t> labels);

}  // namespace diaphane::render
