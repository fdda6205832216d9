#include "api/accounts/language.h"

#include <algorithm>
#include <optional>

namespace diaphane::api {
namespace {

constexpr std::size_t kHeaderBytes = 255;

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Returns whether `tag` ("de", "de-AT") belongs to `language`, which is in lower case.
bool is_of(std::string_view tag, std::string_view language) {
  const std::string_view primary = tag.substr(0, tag.find('-'));
  return std::equal(
      primary.begin(), primary.end(), language.begin(), language.end(),
      [](char c, char lower) { return (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) == lower; });
}

/// Parses the quality value after the ";" of a language, such as "q=0.8", in thousandths. Returns
/// nothing if it is malformed.
std::optional<int> quality_of(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 3 || text.size() > 7 || (text[0] != 'q' && text[0] != 'Q') || text[1] != '=' ||
      (text[2] != '0' && text[2] != '1')) {
    return std::nullopt;
  }
  int quality = (text[2] - '0') * 1000;
  if (text.size() == 3) return quality;
  if (text[3] != '.') return std::nullopt;
  int place = 100;
  for (const char digit : text.substr(4)) {
    if (digit < '0' || digit > '9') return std::nullopt;
    quality += (digit - '0') * place;
    place /= 10;
  }
  return quality > 1000 ? std::nullopt : std::optional(quality);
}

}  // namespace

Language preferred_language(std::string_view accept_language) {
  if (accept_language.size() > kHeaderBytes) return Language::kEnglish;
  Language best = Language::kEnglish;
  int best_quality = 0;
  std::string_view rest = accept_language;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::size_t semicolon = part.find(';');
    const std::string_view tag = trimmed(part.substr(0, semicolon));
    const auto quality =
        semicolon == std::string_view::npos ? 1000 : quality_of(part.substr(semicolon + 1));
    const bool german = is_of(tag, "de");
    if (!quality || *quality <= best_quality || (!german && !is_of(tag, "en"))) continue;
    best = german ? Language::kGerman : Language::kEnglish;
    best_quality = *quality;
  }
  return best;
}

}  // namespace diaphane::api
