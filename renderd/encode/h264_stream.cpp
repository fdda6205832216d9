#include "renderd/encode/h264_stream.h"

#include <cstdio>

namespace diaphane::render {

std::optional<std::string> h264_decoder_name(std::string_view annex_b) {
  constexpr std::string_view kStart("\0\0\1", 3);
  constexpr unsigned kTypeMask = 0x1f;
  constexpr unsigned kSequenceParameterSet = 7;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(annex_b[at]); };
  for (std::size_t at = annex_b.find(kStart); at != std::string_view::npos;
       at = annex_b.find(kStart, at + kStart.size())) {
    const std::size_t unit = at + kStart.size();
    if (unit + 3 >= annex_b.size()) return std::nullopt;
    if ((byte(unit) & kTypeMask) != kSequenceParameterSet) continue;
    char name[16];
    std::snprintf(name, sizeof name, "avc1.%02X%02X%02X", byte(unit + 1), byte(unit + 2),
                  byte(unit + 3));
    return name;
  }
  return std::nullopt;
}

}  // namespace diaphane::render
