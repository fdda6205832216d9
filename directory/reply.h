#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace diaphane::directory {

/// A reply of Redis without hiredis types. Errors are returned as Result instead.
struct Reply {
  enum class Kind { kNil, kInteger, kText, kList };
  Kind kind = Kind::kNil;
  std::int64_t integer = 0;
  std::string text;  ///< bytes, or the text of a status ("OK")
  std::vector<Reply> list;

  /// Returns the text of element `i` of a list, or an empty string.
  const std::string& at(std::size_t i) const {
    static const std::string none;
    return kind == Kind::kList && i < list.size() ? list[i].text : none;
  }
};

}  // namespace diaphane::directory
