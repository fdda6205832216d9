#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Labels on the grid of the file that they come from.
struct LabelImage {
  std::array<std::uint32_t, 3> size{};
  std::array<double, 9> axes{};  ///< steps from voxel to voxel in mm (LPS), as columns
  std::optional<std::array<double, 3>> origin;  ///< centre of the first voxel, mm (LPS)
  std::string frame_of_reference;               ///< empty: unknown
  std::vector<volume::LabelEntry> table;
  std::vector<std::uint8_t> voxels;  ///< as in LabelSet
};

/// Error::field of an error which says that the labels belong to another scan.
inline constexpr const char* kOtherScan = "scan";

/// Returns kInvalid if both the labels and the scan name their frame of reference and the two
/// differ.
Result<void> check_frame_of_reference(const std::string& labels, const volume::Header& scan);

/// Returns the labels on the grid of the scan, by nearest neighbour. If the scan or the image has
/// no position, both must have the same box. Returns kInvalid if they belong to another scan
/// (another frame of reference, another grid, or no overlap), or kOutOfMemory.
Result<volume::LabelSet> place_labels(LabelImage image, const volume::Header& scan);

}  // namespace diaphane::ingest
