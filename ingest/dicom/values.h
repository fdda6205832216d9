#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "ingest/dicom/slice.h"

namespace diaphane::dicom {

/// Hounsfield units of what is not there (air).
inline constexpr std::int32_t kAirHu = -1024;

/// True when to_values handles pixels packed so: 8 or 16 bits allocated, the stored bits within
/// them.
bool is_readable(const PixelLayout& layout);

/// What a pixel that is none (padding) becomes: air, which is nothing elsewhere than in CT.
inline constexpr std::int32_t air_of(volume::Modality modality) {
  return modality == volume::Modality::kCt ? kAirHu : 0;
}

/// Values of one slice.
struct Values {
  std::vector<std::int32_t> values;
  std::size_t padded = 0;  ///< so many of them are air because there was no pixel
};

/// Decoded pixels (little endian, `layout` says how packed) as values:
/// - bits beyond those stored are cleared (overlays hide there), the sign is extended from the
/// highest stored;
/// - MONOCHROME1 is inverted within the range of the stored bits, before any rescale: its files
/// hold the negative of the picture;
/// - pixels that are padding become air;
/// - for CT, value = round(slope x stored + intercept); for others stored units stay, or with a
/// `unit` above 0, where each slice has a scale of its own, value = round((slope x stored +
/// intercept) / unit).
/// Precondition: is_readable(slice.layout), and `raw` holds rows x columns pixels.
Values to_values(std::span<const std::byte> raw, const PixelLayout& layout, const Slice& slice,
                 double unit = 0);

}  // namespace diaphane::dicom
