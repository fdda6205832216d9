#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "ingest/dicom/syntax.h"

namespace diaphane::dicom {

/// What a header says of one of its compressed pictures.
struct PictureClaim {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t components = 1;
  std::uint32_t bits = 16;  ///< allocated for a sample
};

/// Why a decoder may not see a compressed picture, in words; nothing: it may. Walks all that
/// decoders allocate by or loop over: the size that the picture gives itself has to be the claimed
/// one; of JPEG (ITU-T T.81) the process of the transfer syntax, one frame, a scan for each
/// component at most; of JPEG-LS (T.87) no other size in a preset; of JPEG 2000 (T.800, raw or in
/// its box format) a bounded number of tiles, precincts, code-blocks and layers; of RLE (DICOM
/// PS3.5, G) segments that unpack to the size of the picture, counted by going through them.
std::optional<std::string_view> fault_of(std::span<const std::byte> picture,
                                         const TransferSyntax& syntax, const PictureClaim& claim);

}  // namespace diaphane::dicom
