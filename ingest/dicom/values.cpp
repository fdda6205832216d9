#include "ingest/dicom/values.h"

#include <algorithm>
#include <cmath>

namespace diaphane::dicom {

bool is_readable(const PixelLayout& layout) {
  return (layout.bits_allocated == 8 || layout.bits_allocated == 16) && layout.bits_stored >= 1 &&
         layout.bits_stored <= layout.bits_allocated && layout.high_bit < layout.bits_allocated &&
         layout.high_bit + 1 >= layout.bits_stored;
}

Values to_values(std::span<const std::byte> raw, const PixelLayout& layout, const Slice& slice,
                 double unit) {
  const std::size_t count = std::size_t{slice.rows} * slice.columns;
  const std::size_t width = layout.bits_allocated / 8u;
  const unsigned shift = layout.high_bit + 1u - layout.bits_stored;
  const std::uint32_t mask = (1u << layout.bits_stored) - 1;
  const std::uint32_t sign = layout.is_signed ? 1u << (layout.bits_stored - 1) : 0;
  const bool is_ct = slice.modality == volume::Modality::kCt;
  const bool scaled = is_ct || unit > 0;
  const bool invert = shows_negative(slice) && !scaled;
  const double divisor = unit > 0 ? unit : 1;
  const double slope = slice.rescale.slope / divisor, intercept = slice.rescale.intercept / divisor;
  Values result;
  result.values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t bits = std::to_integer<std::uint32_t>(raw[i * width]);
    if (width == 2) bits |= std::to_integer<std::uint32_t>(raw[i * width + 1]) << 8;
    bits = (bits >> shift) & mask;
    // Flipping the sign bit and subtracting it extends two's complement numbers of any width.
    auto stored = static_cast<std::int32_t>(bits ^ sign) - static_cast<std::int32_t>(sign);
    if (slice.padding && stored >= (*slice.padding)[0] && stored <= (*slice.padding)[1]) {
      result.values[i] = air_of(slice.modality);
      ++result.padded;
      continue;
    }
    if (invert) stored = layout.is_signed ? -1 - stored : static_cast<std::int32_t>(mask) - stored;
    if (!scaled) {
      result.values[i] = stored;
      continue;
    }
    const double value = slope * stored + intercept;
    result.values[i] = static_cast<std::int32_t>(std::lround(std::clamp(value, -1e6, 1e6)));
  }
  return result;
}

}  // namespace diaphane::dicom
