#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

enum class VoxelType { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat, kDouble };

/// The size of a voxel in bytes.
std::size_t bytes_of(VoxelType type);

/// What a file in a research format (NIfTI, NRRD or MetaImage) says about its voxels. Fields that
/// could name a person are not read.
struct ImageHeader {
  std::array<std::uint32_t, 3> size{};  ///< of one phase
  VoxelType type = VoxelType::kInt16;
  bool swapped = false;  ///< the byte order differs from this machine's
  double slope = 1, intercept = 0;
  std::array<double, 9> axes{};  ///< steps from voxel to voxel in mm (LPS), as columns
  bool has_axes = false;         ///< false: the file does not state its orientation
  /// Centre of the first voxel in mm (LPS), if the file states it.
  std::optional<std::array<double, 3>> origin;
  std::vector<volume::Phase> phases;  ///< as volume::Header::phases
  volume::Modality modality = volume::Modality::kOther;

  /// The size of the voxels of all phases in bytes.
  std::uint64_t voxels_bytes() const;
};

/// Voxels with their header, phase by phase.
struct Image {
  ImageHeader header;
  std::vector<std::byte> voxels;
};

/// Sets the size and the phases. `step_ms` is the time from phase to phase, or 0 if it is unknown.
/// Returns kInvalid for an empty image, and kTooLarge for more voxels or phases than a volume may
/// have.
Result<void> set_size(ImageHeader& header, std::span<const std::int64_t, 3> size,
                      std::int64_t phases, double step_ms);

/// The error of a file with several values per voxel.
tl::unexpected<Error> several_values();
/// The error of a file whose voxels are of another type.
tl::unexpected<Error> unknown_type();
/// The error of a file that ends early or contradicts itself.
tl::unexpected<Error> damaged_image();

}  // namespace diaphane::ingest
