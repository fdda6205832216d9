#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::ingest {

/// The steps from voxel to voxel in mm (LPS), as columns, that the text header of a MetaImage gives
/// (TransformMatrix, ElementSpacing); VTK's reader passes over the directions.
/// Nothing where the file says none; kInvalid for numbers that make no sense.
Result<std::optional<std::array<double, 9>>> meta_image_axes(const std::string& path);

/// True unless the voxels of a MetaImage, `bytes` of them unpacked, are not all in its file or in
/// the file that it names: VTK's reader leaves then what was in memory before, and says nothing.
bool meta_image_is_whole(const std::string& path, std::uint64_t bytes);
/// The same of an NRRD with encoding raw.
bool nrrd_is_whole(const std::string& path, std::uint64_t bytes);

/// The same of an NRRD ("space", "space directions"; RAS is turned to LPS). kUnsupported for a
/// left-handed or unknown space, whose rows VTK's reader may or may not turn.
Result<std::optional<std::array<double, 9>>> nrrd_axes(const std::string& path);

/// Voxels of an NRRD with encoding gzip, of which VTK's reader takes only the first slice.
struct PackedNrrd {
  std::array<int, 3> size{};
  std::array<double, 3> spacing{1, 1, 1};  ///< mm, where "spacings" gives it
  std::string type;          ///< "int16", "uint16", "uint8", "int8", "float", "double"
  std::vector<char> voxels;  ///< little endian
};
/// Nothing for another encoding, which VTK's reader reads. kUnsupported: big endian, other types, a
/// second file; kInvalid: damaged; kTooLarge.
Result<std::optional<PackedNrrd>> read_packed_nrrd(const std::string& path);

/// From the right-anterior frame of NIfTI and of NRRD's RAS to the left-posterior one.
std::array<double, 9> ras_to_lps(std::array<double, 9> axes);

}  // namespace diaphane::ingest
