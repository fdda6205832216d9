#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/precheck.h"

namespace diaphane::dicom {

/// An element of the top level, header and value.
struct Range {
  std::uint32_t tag = 0;
  std::size_t begin = 0, end = 0;
};

/// What the walk over a data set found at its top level.
struct Walked {
  FileState state = FileState::kFit;
  std::string text;
  std::optional<std::uint16_t> rows, columns, samples, bits_allocated;
  std::optional<std::uint64_t> frames;
  bool has_lookup_table = false;  ///< a Modality LUT Sequence
  std::vector<Range>
      kept;  ///< those elements that a volume depends on, by rising tag; no sequences
  bool has_pixels = false;
  bool encapsulated = false;
  std::uint64_t pixel_length = 0;             ///< bytes of native pixels
  std::span<const std::byte> first_fragment;  ///< of compressed pixels
};

/// Checks the structure of a data set (DICOM PS3.5, 7): see precheck().
Walked walk(std::span<const std::byte> data, bool explicit_vr, bool big_endian,
            const Limits& limits);

}  // namespace diaphane::dicom
