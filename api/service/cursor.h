#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// Where a page of a newest-first list ended: the creation time of its last entry and, among
/// equals, its id.
struct Cursor {
  std::int64_t created_us = 0;  ///< microseconds since 1970, as Postgres keeps them
  std::string id;

  friend bool operator==(const Cursor&, const Cursor&) = default;
};

/// Opaque to the client, URL-safe.
std::string encode_cursor(const Cursor& cursor);
/// kInvalid for anything that encode_cursor did not make.
Result<Cursor> decode_cursor(std::string_view text);

}  // namespace diaphane::api
