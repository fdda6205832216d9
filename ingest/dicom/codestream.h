#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "ingest/dicom/syntax.h"

namespace diaphane::dicom {

struct PictureSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t components = 0;
};

/// The size that a compressed picture gives itself, which is what its decoder allocates: the SOF
/// marker of JPEG (ITU-T T.81, B.2.2) and JPEG-LS (T.87), the SIZ marker of JPEG 2000 (T.800,
/// A.5.1), raw or in its box format. Nothing when there is none. RLE has no size of its own.
std::optional<PictureSize> picture_size(std::span<const std::byte> fragment, Packing packing);

}  // namespace diaphane::dicom
