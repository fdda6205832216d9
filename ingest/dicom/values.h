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

/// Decoded pixels (little endian, `layout` says how packed) as values:
/// - bits beyond those stored are cleared (overlays hide there), the sign is extended from the
/// highest stored;
/// - MONOCHROME1 is inverted within the range of the stored bits, before any rescale: its files
/// hold the
///   negative of the picture;
/// - for CT, value = round(slope x stored + intercept), and pixels that are padding become air; for
/// others
///   stored units stay.
/// Precondition: is_readable(slice.layout), and `raw` holds rows x columns pixels.
std::vector<std::int32_t> to_values(std::span<const std::byte> raw, const PixelLayout& layout,
                                    const Slice& slice);

}  // namespace diaphane::dicom
