#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace diaphane::directory {

// Lists of IDs in one field of Redis, separated by commas.

inline std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& word : names) text += (text.empty() ? "" : ",") + word;
  return text;
}

inline std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    if (comma != 0) parts.emplace_back(text.substr(0, comma));
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return parts;
}

}  // namespace diaphane::directory
