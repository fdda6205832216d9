#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "ingest/dicom/syntax.h"

namespace diaphane::dicom {

/// What the DICOM header claims about one of its compressed images.
struct PictureClaim {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t components = 1;
  std::uint32_t bits = 16;  ///< bits allocated per sample
};

/// Returns why a decoder must not read a compressed image, or nullopt if it may. Checks everything
/// that decoders allocate or loop by. The size in the image must be the claimed size. For JPEG
/// (ITU-T T.81), it allows only the process of the transfer syntax, one frame, and at most one scan
/// per component. For JPEG-LS (T.87), it allows no other size in a preset. For JPEG 2000 (T.800,
/// raw or in its box format), it limits the number of tiles, precincts, code-blocks and layers. For
/// RLE (DICOM PS3.5, G), it walks the segments to check that they unpack to the size of the image.
std::optional<std::string_view> fault_of(std::span<const std::byte> picture,
                                         const TransferSyntax& syntax, const PictureClaim& claim);

}  // namespace diaphane::dicom
