#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace diaphane::api::redis {

/// What Redis answered, without hiredis's types. Errors never get here (they are Result's).
struct Reply {
  enum class Kind { kNil, kInteger, kText, kList };
  Kind kind = Kind::kNil;
  std::int64_t integer = 0;
  std::string text;  ///< bytes; also of a status ("OK")
  std::vector<Reply> list;

  /// The text of element `i` of a list; empty when there is none.
  const std::string& at(std::size_t i) const {
    static const std::string none;
    return kind == Kind::kList && i < list.size() ? list[i].text : none;
  }
};

}  // namespace diaphane::api::redis
