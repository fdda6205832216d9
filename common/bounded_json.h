#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>
#include <tl/expected.hpp>

/// JSON from outside. The parser of nlohmann::json does not recurse, but its values are copied,
/// compared and written recursively, so nesting costs stack; and a value takes up to 160 bytes, so
/// that two characters ("[]") can cost 88 bytes of memory. Both are bounded here before the first
/// value is built.
namespace diaphane {

/// Far more than any format of ours needs (a scene has 8 levels), far less than a stack holds.
inline constexpr int kDeepestJson = 64;

struct JsonLimits {
  std::size_t values = 0;  ///< objects, arrays and scalars together
  int depth = kDeepestJson;
};

enum class JsonFault { kMalformed, kTooDeep, kTooManyValues };

/// The first limit that is exceeded is reported even when the rest of the text is malformed.
tl::expected<nlohmann::json, JsonFault> parse_json(std::string_view text, const JsonLimits& limits);

}  // namespace diaphane
