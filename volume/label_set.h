#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace diaphane::volume {

struct Header;

/// One small number per voxel, in the order of Volume::voxels.
struct Labels {
  std::array<std::uint32_t, 3> size{};
  std::vector<std::uint8_t> voxels;
};

/// Limits of a label set. Voxels have one byte, and 0 means no label.
inline constexpr std::size_t kMostLabels = 255;
inline constexpr std::size_t kLongestLabelName = 64;  ///< bytes of UTF-8

/// The name of a label of a scan, and how it is shown at first.
struct LabelEntry {
  std::uint32_t number = 0;  ///< number in the original file; unique within a set, not 0
  std::string name;          ///< empty if the file has none
  std::array<std::uint8_t, 3> colour{};  ///< sRGB

  bool operator==(const LabelEntry&) const = default;
};

/// Structures that somebody has marked in a scan, on the scan's grid. A voxel of value i > 0
/// belongs to entry i - 1 of the table, and a voxel of value 0 to none.
struct LabelSet {
  std::vector<LabelEntry> table;
  Labels labels;

  bool empty() const { return table.empty(); }
};

/// Returns a colour for a label whose file gives none. Successive indices get very different
/// colours.
std::array<std::uint8_t, 3> label_colour(std::size_t index);

/// Returns the name without control characters, as valid UTF-8 and no longer than allowed.
std::string clean_label_name(std::string_view name);

/// Returns the table and the run lengths of the voxels (labels.h).
std::string encode(const LabelSet& set);

/// Reads what encode() returned for a volume of `size`. Returns kInvalid if the bytes are damaged,
/// have another version or belong to a volume of another size. Allocates no more than one byte per
/// voxel of `size` and the table, whatever the bytes say.
Result<LabelSet> decode_label_set(std::string_view bytes, std::array<std::uint32_t, 3> size);

/// Returns the largest possible size of an encoded label set: its table, and a run of two bytes for
/// each voxel.
std::uint64_t most_label_set_bytes(const Header& header);

}  // namespace diaphane::volume
