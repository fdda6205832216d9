#include "api/accounts/common_passwords.h"

#include <algorithm>
#include <set>

#include "api/accounts/common_passwords.txt.h"

namespace diaphane::api {
namespace {

/// Maximum of digits and symbols around a word: attackers also try a year, "123!" or "123456".
constexpr std::size_t kFewSigns = 6;
constexpr std::size_t kShortestRepeated = 4;

std::set<std::string_view> read_list(std::string_view text) {
  std::set<std::string_view> words;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with('#')) continue;
    while (!line.empty()) {
      const std::size_t blank = std::min(line.find(' '), line.size());
      words.insert(line.substr(0, blank));
      line.remove_prefix(std::min(blank + 1, line.size()));
    }
  }
  return words;
}

bool is_listed(std::string_view word) {
  static const std::set<std::string_view> words = read_list(kCommonPasswords);
  return words.contains(word);
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (static_cast<unsigned char>(c) & 0x80) != 0;
}

std::string_view without_signs_around(std::string_view text) {
  while (!text.empty() && !is_letter(text.front())) text.remove_prefix(1);
  while (!text.empty() && !is_letter(text.back())) text.remove_suffix(1);
  return text;
}

bool repeats(std::string_view text, std::size_t unit) {
  for (std::size_t i = unit; i < text.size(); ++i) {
    if (text[i] != text[i - unit]) return false;
  }
  return true;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Returns whether the text consists of consecutive letters or digits, with 0 after 9.
bool counts_by(std::string_view text, int step) {
  for (std::size_t i = 1; i < text.size(); ++i) {
    const int apart = text[i] - text[i - 1];
    const bool wraps = is_digit(text[i]) && is_digit(text[i - 1]) && apart == -9 * step;
    if (apart != step && !wraps) return false;
  }
  return true;
}

}  // namespace

std::optional<std::string> weakness_of(std::string_view password, std::string_view user_word) {
  std::string text(password);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  constexpr const char* kCommon = "This password is too common. Choose another one.";
  if (is_listed(text)) return kCommon;
  const std::string_view core = without_signs_around(text);
  const bool only_few_around = text.size() - core.size() <= kFewSigns;
  if (core.size() >= 5 && only_few_around) {
    if (is_listed(core)) return kCommon;
    if (core == "diaphane" || core == user_word) {
      return "This password is too easy to guess because it is based on a name. Choose another "
             "one.";
    }
  }
  for (std::size_t unit = 1; unit <= text.size() / 2; ++unit) {
    if (!repeats(text, unit)) continue;
    // Four bytes are two letters in most non-Latin scripts.
    if (unit <= kShortestRepeated || is_listed(text.substr(0, unit))) {
      return "This password is too repetitive. Choose another one.";
    }
  }
  if (counts_by(text, 1) || counts_by(text, -1)) return kCommon;
  return std::nullopt;
}

}  // namespace diaphane::api
