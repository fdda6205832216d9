#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

enum class NiftiType { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat, kDouble };

/// The header of the file that the page sends for a scan in a research format (NIfTI, NRRD or
/// MetaImage): NIfTI-1 with uncompressed voxels and a new header (docs/contracts.md, "Upload
/// bundle"). Fields that could name a person are not read.
struct NiftiHeader {
  std::array<std::uint32_t, 3> size{};
  NiftiType type = NiftiType::kInt16;
  std::size_t voxel_bytes = 0;
  bool swapped = false;          ///< the byte order differs from this machine's
  std::size_t voxels_begin = 0;  ///< offset of the voxels in the file
  double slope = 1, intercept = 0;
  std::array<double, 9> axes{};       ///< steps from voxel to voxel in mm (LPS), as columns
  std::array<double, 3> origin{};     ///< centre of the first voxel in mm (LPS), if `has_axes`
  bool has_axes = false;              ///< false: the file does not state its orientation
  std::vector<volume::Phase> phases;  ///< as volume::Header::phases
  volume::Modality modality = volume::Modality::kOther;
};

/// Returns whether a file begins like NIfTI-1, in either byte order.
bool is_nifti(std::span<const std::byte> file);

/// Parses the header. Returns kInvalid for a damaged or incomplete file, kUnsupported for other
/// voxel types, several values per voxel or voxels in another file, and kTooLarge for more voxels
/// or phases than a volume may have.
Result<NiftiHeader> read_nifti_header(std::span<const std::byte> file);

/// Returns a measured volume, converted to int16 as in read_image(), or an error of read_image().
/// Precondition: `header` is the result of read_nifti_header(file).
Result<volume::Volume> read_nifti_voxels(std::span<const std::byte> file,
                                         const NiftiHeader& header);

}  // namespace diaphane::ingest
