#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"
#include "ingest/dicom/walk.h"
#include "ingest/labels/label_image.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Limits on a file of labels.
struct LabelLimits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;      ///< size as stored
  std::uint64_t unpacked_bytes = std::uint64_t{1} << 31;  ///< size of a .nii.gz after decompression
  std::uint64_t voxels = std::uint64_t{1} << 30;          ///< size of the file's own grid
  std::uint64_t points = 5'000'000;                       ///< total of all contours in the file
};

/// Reads a NIfTI label volume (also compressed), a DICOM segmentation (SEG) or a DICOM structure
/// set (RTSTRUCT), and returns its labels on the grid of the scan. Where structures overlap, the
/// later one wins, and in a fractional segmentation the one with the larger fraction.
///
/// Returns kInvalid if the file is damaged, has no labels or belongs to another scan, kUnsupported
/// for another kind of file, kTooLarge for more labels, voxels or points than allowed, or
/// kOutOfMemory.
Result<volume::LabelSet> read_labels(std::span<const std::byte> file, const volume::Header& scan,
                                     const LabelLimits& limits = {});
/// Like read_labels, for the file at `path`. Also returns kNotFound.
Result<volume::LabelSet> read_label_file(const std::string& path, const volume::Header& scan,
                                         const LabelLimits& limits = {});

/// Reads whole numbers of any voxel type as labels, where 0 stands for none.
Result<LabelImage> read_nifti_labels(std::span<const std::byte> file, const LabelLimits& limits);
/// Reads a segmentation that is not compressed. A voxel belongs to a segment of a fractional one if
/// the fraction is at least one half.
Result<LabelImage> read_segmentation(const dicom::DataSet& file, const LabelLimits& limits);
/// Fills the closed planar contours of a structure set by the even-odd rule. Their planes must be
/// parallel to the scan's slices along one of its axes. Contours apply to the nearest slices, up to
/// half the smallest distance of planes.
Result<volume::LabelSet> read_structure_set(const dicom::DataSet& file, const volume::Header& scan,
                                            const LabelLimits& limits);

}  // namespace diaphane::ingest
