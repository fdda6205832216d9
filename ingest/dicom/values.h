#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "ingest/dicom/slice.h"

namespace diaphane::dicom {

/// Hounsfield units for missing pixels (air).
inline constexpr std::int32_t kAirHu = -1024;

/// Returns whether to_values supports this layout: 8 or 16 bits allocated, with the stored bits
/// within them.
bool is_readable(const PixelLayout& layout);

/// Returns the value for padding pixels: air for CT, 0 for other modalities.
inline constexpr std::int32_t air_of(volume::Modality modality) {
  return modality == volume::Modality::kCt ? kAirHu : 0;
}

/// Values of one slice.
struct Values {
  std::vector<std::int32_t> values;
  std::size_t padded = 0;  ///< number of values set to air because the pixel was padding
};

/// Returns whether low values are to be displayed bright.
inline bool shows_negative(const Slice& slice) { return slice.photometric == "MONOCHROME1"; }

/// Converts decoded pixels (little endian, packed according to `layout`) to values:
/// - It clears bits beyond those stored, where overlays may be, and extends the sign from the
/// highest stored bit.
/// - It inverts MONOCHROME1 within the range of the stored bits, but not where values have physical
/// units. There, the attribute says how to display the values and not what they mean.
/// - Padding pixels become air.
/// - For CT, value = round(slope x stored + intercept). For other modalities, stored units are
/// kept. If `unit` is above 0, because each slice has its own scale, value = round((slope x stored
/// + intercept) / unit).
/// Precondition: is_readable(slice.layout), and `raw` holds rows x columns pixels.
Values to_values(std::span<const std::byte> raw, const PixelLayout& layout, const Slice& slice,
                 double unit = 0);

}  // namespace diaphane::dicom
