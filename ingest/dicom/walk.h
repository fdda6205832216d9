#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/precheck.h"

namespace diaphane::dicom {

/// What the walk over a data set found at its top level, and in the functional groups.
struct Walked {
  FileState state = FileState::kFit;
  std::string text;
  std::optional<std::uint16_t> rows, columns, samples, bits_allocated;
  std::optional<std::uint64_t> frames;
  bool has_lookup_table = false;  ///< a Modality LUT Sequence
  std::vector<Range>
      kept;  ///< those elements that a volume depends on, by rising tag; no sequences, no pixels
  bool has_pixels = false;
  bool encapsulated = false;
  Range native;                  ///< value of native pixels
  std::vector<Range> fragments;  ///< values of the items of compressed pixels; 0: offset table
  Range long_offsets;            ///< value of the Extended Offset Table; empty: there is none
  bool has_groups = false;       ///< there are functional groups
  std::vector<Range> shared;     ///< values that all frames have in common
  std::vector<std::vector<Range>> each;  ///< values that each frame has of its own
};

/// Checks the structure of a data set (DICOM PS3.5, 7): see precheck().
Walked walk(std::span<const std::byte> data, bool explicit_vr, bool big_endian,
            const Limits& limits);

}  // namespace diaphane::dicom
