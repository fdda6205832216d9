#include "api/shared/cursor.h"

#include <charconv>

#include "common/ids.h"

namespace diaphane::api {

// "<microseconds in hexadecimal>.<id>" needs no further encoding in a URL.
std::string encode_cursor(const Cursor& cursor) {
  char number[17];
  const auto end = std::to_chars(number, number + sizeof number,
                                 static_cast<std::uint64_t>(cursor.created_us), 16);
  return std::string(number, end.ptr) + "." + cursor.id;
}

Result<Cursor> decode_cursor(std::string_view text) {
  const auto refused = [] { return fail(ErrorCode::kInvalid, "Invalid cursor.", "cursor"); };
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos || dot == 0 || dot > 15) return refused();
  std::uint64_t number = 0;
  const char* const last = text.data() + dot;
  const auto [end, error] = std::from_chars(text.data(), last, number, 16);
  if (error != std::errc() || end != last || number > (std::uint64_t{1} << 56)) return refused();
  Cursor cursor{static_cast<std::int64_t>(number), std::string(text.substr(dot + 1))};
  if (!is_id(cursor.id) || encode_cursor(cursor) != text) return refused();
  return cursor;
}

}  // namespace diaphane::api
