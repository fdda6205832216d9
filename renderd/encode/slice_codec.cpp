#include "renderd/encode/slice_codec.h"

#include <zlib.h>

#include <algorithm>
#include <string_view>

namespace diaphane::render {
namespace {

Result<std::string> compressed(std::string_view bytes) {
  uLongf length = compressBound(static_cast<uLong>(bytes.size()));
  std::string coded(length, '\0');
  // The fastest level, because a user is scrolling through slices.
  constexpr int kLevel = 1;
  if (compress2(reinterpret_cast<Bytef*>(coded.data()), &length,
                reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()),
                kLevel) != Z_OK) {
    return fail(ErrorCode::kInternal, "The slice could not be encoded.");
  }
  coded.resize(length);
  return coded;
}

}  // namespace

Result<std::string> code_slice(std::span<const std::int16_t> values) {
  const std::size_t n = values.size();
  std::string bytes(2 * n, '\0');
  for (std::size_t i = 0; i < n; ++i) {
    const auto bits = static_cast<std::uint16_t>(values[i]);
    bytes[i] = static_cast<char>(bits & 0xff);
    bytes[n + i] = static_cast<char>(bits >> 8);
  }
  return compressed(bytes);
}

Result<std::string> code_labels(std::span<const std::uint8_t> labels) {
  if (std::ranges::all_of(labels, [](std::uint8_t label) { return label == 0; })) return {};
  return compressed({reinterpret_cast<const char*>(labels.data()), labels.size()});
}

}  // namespace diaphane::render
