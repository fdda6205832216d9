#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// The end of a page of a newest-first list: the creation time of its last entry and, to break
/// ties, its ID.
struct Cursor {
  std::int64_t created_us = 0;  ///< microseconds since 1970, the precision of Postgres
  std::string id;

  friend bool operator==(const Cursor&, const Cursor&) = default;
};

/// Encodes the cursor as URL-safe text that is opaque to clients.
std::string encode_cursor(const Cursor& cursor);
/// Returns kInvalid for anything that encode_cursor did not create.
Result<Cursor> decode_cursor(std::string_view text);

}  // namespace diaphane::api
