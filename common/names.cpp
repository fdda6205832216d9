#include "common/names.h"

#include <algorithm>
#include <array>

namespace diaphane {
namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0 means invalid UTF-8
};

Character decode(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (length == 0 || first > 0xf4 || text.size() < length) return {};
  char32_t code = first & (0x7f >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = (code << 6) | (byte(i) & 0x3f);
  }
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kSmallest[length] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
  return {code, length};
}

bool is_space(char32_t c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == 0xa0 || c == 0x1680 ||
         (c >= 0x2000 && c <= 0x200a) || c == 0x2028 || c == 0x2029 || c == 0x202f || c == 0x205f ||
         c == 0x3000;
}

// Characters that are invisible or change how their neighbours are displayed. They would let one
// name pass for another.
bool is_hidden(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0xad || c == 0x61c || c == 0x180e ||
         (c >= 0x200b && c <= 0x200f) || (c >= 0x202a && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0xfeff || (c >= 0xfff0 && c <= 0xffff) ||
         (c >= 0xe000 && c <= 0xf8ff) || c >= 0xe0000;
}

struct Range {
  char32_t first, last;
};

// Non-ASCII punctuation, symbols and letters that resemble others. An email client may turn a host
// name with such characters into a link.
constexpr std::array kNotInNames{
    Range{0xa1, 0xa9},     Range{0xab, 0xb4},     Range{0xb6, 0xb9},       Range{0xbb, 0xbf},
    Range{0xd7, 0xd7},     Range{0xf7, 0xf7},     Range{0x2b9, 0x2ba},     Range{0x2c2, 0x2df},
    Range{0x37e, 0x37e},   Range{0x387, 0x387},   Range{0x55a, 0x55f},     Range{0x589, 0x58a},
    Range{0x5be, 0x5be},   Range{0x5c0, 0x5c0},   Range{0x5c3, 0x5c3},     Range{0x5f3, 0x5f4},
    Range{0x600, 0x60f},   Range{0x61b, 0x61f},   Range{0x66a, 0x66d},     Range{0x6d4, 0x6d4},
    Range{0x700, 0x70d},   Range{0x964, 0x965},   Range{0xe2f, 0xe2f},     Range{0x104a, 0x104f},
    Range{0x10fb, 0x10fb}, Range{0x1360, 0x1368}, Range{0x17d4, 0x17da},   Range{0x2000, 0x200f},
    Range{0x2012, 0x2018}, Range{0x201a, 0x2bff}, Range{0x2e00, 0x2e7f},   Range{0x3000, 0x3004},
    Range{0x3008, 0x3020}, Range{0x3030, 0x303f}, Range{0x3200, 0x33ff},   Range{0xa4f8, 0xa4ff},
    Range{0xa789, 0xa78a}, Range{0xfe00, 0xfe6f}, Range{0xff00, 0xff20},   Range{0xff3b, 0xff40},
    Range{0xff5b, 0xff65}, Range{0xffe0, 0xffff}, Range{0x1d000, 0x1ffff},
};

bool is_of_a_name(char32_t c) {
  if (c >= 0x80) {
    return std::none_of(kNotInNames.begin(), kNotInNames.end(),
                        [c](const Range& r) { return c >= r.first && c <= r.last; });
  }
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' ||
         c == '.' || c == '-' || c == '\'';
}

}  // namespace

std::string clean_name(std::string_view typed, std::size_t most) {
  std::string name;
  bool space = false;
  for (std::size_t characters = 0; !typed.empty() && characters < most;) {
    const Character next = decode(typed);
    const std::string_view bytes = typed.substr(0, std::max<std::size_t>(next.bytes, 1));
    typed.remove_prefix(bytes.size());
    if (next.bytes == 0) continue;
    if (is_space(next.code)) {
      space = !name.empty();
      continue;
    }
    if (is_hidden(next.code)) continue;
    if (space) {
      if (++characters == most) break;
      name += ' ';
    }
    space = false;
    name += bytes;
    ++characters;
  }
  return name;
}

bool is_plain_name(std::string_view clean) {
  while (!clean.empty()) {
    const Character next = decode(clean);
    if (next.bytes == 0 || !is_of_a_name(next.code)) return false;
    clean.remove_prefix(next.bytes);
    // "evil.example" is a host name; "J. R. Smith" is not.
    if (next.code == '.' && !clean.empty() && clean.front() != ' ') return false;
  }
  return true;
}

}  // namespace diaphane
