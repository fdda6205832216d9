#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"
#include "ingest/build/image_header.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The header of a NIfTI-1 or NIfTI-2 file with its voxels. The page sends a scan in a research
/// format (NIfTI, NRRD or MetaImage) as NIfTI-1 with uncompressed voxels and a new header
/// (docs/contracts.md, "Upload bundle").
struct NiftiHeader : ImageHeader {
  std::size_t voxels_begin = 0;  ///< offset of the voxels in the file
};

/// Returns whether a file begins like NIfTI-1 or NIfTI-2, in either byte order.
bool is_nifti(std::span<const std::byte> file);

/// Parses the header. Returns kInvalid for a damaged or incomplete file, kUnsupported for other
/// voxel types, several values per voxel or voxels in another file, and kTooLarge for more voxels
/// or phases than a volume may have.
Result<NiftiHeader> read_nifti_header(std::span<const std::byte> file);

/// Returns a measured volume, converted to int16 as in read_image(), or an error of read_image().
/// Precondition: `header` is the result of read_nifti_header(file).
Result<volume::Volume> read_nifti_voxels(std::span<const std::byte> file,
                                         const NiftiHeader& header);

/// Returns the file with only these phases, whose numbers ascend. Their times are kept if the
/// phases are equally far apart. Precondition: they exist, and `header` is that of the file.
std::string keep_nifti_phases(std::span<const std::byte> file, const NiftiHeader& header,
                              std::span<const std::uint32_t> kept);

}  // namespace diaphane::ingest
