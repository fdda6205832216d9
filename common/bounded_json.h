#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>
#include <tl/expected.hpp>

/// Parses untrusted JSON. The parser of nlohmann::json does not recurse, but it copies, compares
/// and serialises values recursively, so deep nesting uses stack. A value takes up to 160 bytes, so
/// two characters ("[]") can use 88 bytes of memory. Both costs are bounded here before the first
/// value is built.
namespace diaphane {

/// Far more than any of our formats needs (a scene has 8 levels) and far less than a stack holds.
inline constexpr int kDeepestJson = 64;

struct JsonLimits {
  std::size_t values = 0;  ///< objects, arrays and scalars together
  int depth = kDeepestJson;
};

enum class JsonFault { kMalformed, kTooDeep, kTooManyValues };

/// Parses `text`, or returns the first limit that it exceeds, even if the rest of it is malformed.
tl::expected<nlohmann::json, JsonFault> parse_json(std::string_view text, const JsonLimits& limits);

}  // namespace diaphane
