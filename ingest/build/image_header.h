#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::ingest {

/// Returns the steps from voxel to voxel in mm (LPS), as columns, from the text header of a
/// MetaImage (TransformMatrix, ElementSpacing). VTK's reader ignores the directions. Returns
/// nullopt if the header has none, kInvalid for implausible numbers, and kUnsupported for voxels of
/// 64-bit integers or of an unknown type, for which VTK's reader writes beyond its memory.
Result<std::optional<std::array<double, 9>>> meta_image_axes(const std::string& path);

/// Returns false if the voxels of a MetaImage, `bytes` in size when unpacked, are not complete in
/// its file or in the file that it names. VTK's reader then silently leaves the previous contents
/// of the memory.
bool meta_image_is_complete(const std::string& path, std::uint64_t bytes);
/// Like meta_image_is_complete, for an NRRD with encoding raw.
bool nrrd_is_complete(const std::string& path, std::uint64_t bytes);

/// Like meta_image_axes, for an NRRD ("space", "space directions"). Converts RAS to LPS. Returns
/// kUnsupported for a left-handed or unknown space, because VTK's reader does not turn its rows
/// reliably.
Result<std::optional<std::array<double, 9>>> nrrd_axes(const std::string& path);

/// Voxels of an NRRD with encoding gzip, of which VTK's reader would read only the first slice.
struct PackedNrrd {
  std::array<int, 3> size{};
  std::array<double, 3> spacing{1, 1, 1};  ///< mm, from "spacings" if present
  std::string type;          ///< "int16", "uint16", "uint8", "int8", "float", "double"
  std::vector<char> voxels;  ///< little endian
};
/// Returns the voxels, or nullopt for another encoding, which VTK's reader handles. Returns
/// kUnsupported for big-endian voxels, other types or a second file, kInvalid for a damaged file,
/// and kTooLarge for more voxels than a volume may have.
Result<std::optional<PackedNrrd>> read_packed_nrrd(const std::string& path);

/// Returns the contents of a file, decompressed if it is compressed with gzip. Returns kInvalid for
/// a damaged file, and kTooLarge for more bytes than the largest volume has.
Result<std::vector<std::byte>> unpacked_file(const std::string& path);

/// Converts axes from the right-anterior frame of NIfTI and NRRD's RAS to the left-posterior frame.
std::array<double, 9> ras_to_lps(std::array<double, 9> axes);

}  // namespace diaphane::ingest
