#include "api/routing/target.h"

#include <algorithm>

namespace diaphane::api {
namespace {

constexpr std::size_t kMaxTarget = 2048;

bool is_path_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.' || c == '/';
}

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Decodes percent-escapes and `+`. Returns nothing for a bad escape or a control character.
std::optional<std::string> decode(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i] == '+' ? ' ' : text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_value(text[i + 1]), low = hex_value(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return std::nullopt;
    decoded += c;
  }
  return decoded;
}

std::string_view next_segment(std::string_view& rest) {
  const std::size_t slash = rest.find('/');
  const std::string_view segment = rest.substr(0, slash);
  rest = slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
  return segment;
}

}  // namespace

Outcome<Target> parse_target(std::string_view target) {
  const auto refused = [] { return refuse(ProblemKind::kBadRequest, "The URL is malformed."); };
  if (target.size() > kMaxTarget) return refused();
  const std::size_t mark = target.find('?');
  const std::string_view path = target.substr(0, mark);
  if (path.empty() || path.front() != '/' ||
      !std::all_of(path.begin(), path.end(), is_path_character) ||
      path.find("//") != std::string_view::npos || path.find("/.") != std::string_view::npos) {
    return refused();
  }
  Target parsed{std::string(path), {}};
  if (mark == std::string_view::npos) return parsed;
  std::string_view rest = target.substr(mark + 1);
  while (!rest.empty()) {
    const std::size_t amp = rest.find('&');
    const std::string_view pair = rest.substr(0, amp);
    rest = amp == std::string_view::npos ? std::string_view() : rest.substr(amp + 1);
    const std::size_t equals = pair.find('=');
    const auto name = decode(pair.substr(0, equals));
    const auto value =
        decode(equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1));
    if (!name || !value) return refused();
    if (!parsed.query.emplace(*name, *value).second) {
      return refuse(ProblemKind::kBadRequest, "A query parameter is given more than once.");
    }
  }
  return parsed;
}

std::optional<std::map<std::string, std::string>> match_path(std::string_view pattern,
                                                             std::string_view path) {
  std::map<std::string, std::string> parameters;
  if (std::count(pattern.begin(), pattern.end(), '/') !=
      std::count(path.begin(), path.end(), '/')) {
    return std::nullopt;
  }
  while (!pattern.empty() || !path.empty()) {
    const std::string_view form = next_segment(pattern);
    const std::string_view segment = next_segment(path);
    if (form.starts_with('{')) {
      if (segment.empty()) return std::nullopt;
      parameters.emplace(form.substr(1, form.size() - 2), segment);
    } else if (form != segment) {
      return std::nullopt;
    }
  }
  return parameters;
}

}  // namespace diaphane::api
