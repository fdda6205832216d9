#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/precheck.h"

namespace diaphane::dicom {

/// What the walk over a data set found at its top level and in its functional groups.
struct Walked {
  FileState state = FileState::kFit;
  std::string text;
  std::optional<std::uint16_t> rows, columns, samples, bits_allocated;
  std::optional<std::uint64_t> frames;
  bool has_lookup_table = false;  ///< has a Modality LUT Sequence
  std::vector<Range>
      kept;  ///< elements that a volume depends on, by rising tag, without sequences and pixels
  bool has_pixels = false;
  bool encapsulated = false;
  Range native;  ///< value of native pixels
  std::vector<Range>
      fragments;       ///< values of the items of compressed pixels; item 0 is the offset table
  Range long_offsets;  ///< value of the Extended Offset Table, if any
  bool has_groups = false;               ///< has functional groups
  std::vector<Range> shared;             ///< values shared by all frames
  std::vector<std::vector<Range>> each;  ///< values per frame
};

/// An element of a data set. Compressed pixels have no value.
struct DataElement;
using DataSet = std::vector<DataElement>;  ///< a data set, or one item of a sequence
struct DataElement {
  std::uint32_t tag = 0;
  std::span<const std::byte> value;  ///< points into the walked data
  std::vector<DataSet> items;        ///< items of a sequence
};

/// Checks the structure of a data set (DICOM PS3.5, 7). See precheck(). `tree`, if given, receives
/// all elements, valid if the result is fit.
Walked walk(std::span<const std::byte> data, bool explicit_vr, bool big_endian,
            const Limits& limits, DataSet* tree = nullptr);

}  // namespace diaphane::dicom
