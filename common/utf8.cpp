#include "common/utf8.h"

#include <cstddef>
#include <cstdint>

namespace diaphane {
namespace {

struct Lead {
  std::size_t bytes = 0;  // 0: not a valid first byte
  std::uint32_t bits = 0;
  std::uint32_t least = 0;  // smallest character that needs this many bytes
};

Lead lead_of(std::uint8_t byte) {
  if (byte < 0x80) return {1, byte, 0};
  if ((byte & 0xe0) == 0xc0) return {2, byte & 0x1fU, 0x80};
  if ((byte & 0xf0) == 0xe0) return {3, byte & 0x0fU, 0x800};
  if ((byte & 0xf8) == 0xf0) return {4, byte & 0x07U, 0x10000};
  return {};
}

}  // namespace

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const Lead lead = lead_of(static_cast<std::uint8_t>(text[i]));
    if (lead.bytes == 0 || lead.bytes > text.size() - i) return false;
    std::uint32_t character = lead.bits;
    for (std::size_t k = 1; k < lead.bytes; ++k) {
      const auto byte = static_cast<std::uint8_t>(text[i + k]);
      if ((byte & 0xc0) != 0x80) return false;
      character = character << 6 | (byte & 0x3fU);
    }
    const bool surrogate = character >= 0xd800 && character <= 0xdfff;
    if (character < lead.least || character > 0x10ffff || surrogate) return false;
    i += lead.bytes;
  }
  return true;
}

}  // namespace diaphane
