#include "ingest/build/image_header.h"

#include <cmath>
#include <string>

#include "volume/header.h"

namespace diaphane::ingest {

std::size_t bytes_of(VoxelType type) {
  switch (type) {
    case VoxelType::kUint8:
    case VoxelType::kInt8:
      return 1;
    case VoxelType::kUint16:
    case VoxelType::kInt16:
      return 2;
    case VoxelType::kUint32:
    case VoxelType::kInt32:
    case VoxelType::kFloat:
      return 4;
    case VoxelType::kDouble:
      break;
  }
  return 8;
}

std::uint64_t ImageHeader::voxels_bytes() const {
  return std::uint64_t{size[0]} * size[1] * size[2] * std::max<std::size_t>(phases.size(), 1) *
         bytes_of(type);
}

Result<void> set_size(ImageHeader& header, std::span<const std::int64_t, 3> size,
                      std::int64_t phases, double step_ms) {
  if (phases > volume::kMostPhases) {
    return fail(ErrorCode::kTooLarge,
                "it has " + std::to_string(phases) + " phases, and at most 1,000 are supported");
  }
  if (phases < 1) return fail(ErrorCode::kInvalid, "the image is empty");
  std::uint64_t voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (size[axis] < 1) return fail(ErrorCode::kInvalid, "the image is empty");
    if (size[axis] > volume::kMaxSide) return fail(ErrorCode::kTooLarge, "the image is too large");
    header.size[axis] = static_cast<std::uint32_t>(size[axis]);
    voxels *= header.size[axis];
  }
  if (voxels * static_cast<std::uint64_t>(phases) > volume::kMaxVoxels) {
    return fail(ErrorCode::kTooLarge, "the image is too large");
  }
  const bool timed = std::isfinite(step_ms) && step_ms > 0;
  for (std::int64_t i = 0; phases > 1 && i < phases; ++i) {
    const auto index = static_cast<double>(i);
    header.phases.push_back({timed ? volume::PhaseKind::kTime : volume::PhaseKind::kIndex,
                             timed ? index * step_ms : index});
  }
  return {};
}

tl::unexpected<Error> several_values() {
  return fail(ErrorCode::kUnsupported,
              "this file has several values per voxel, such as colours or vectors");
}

tl::unexpected<Error> unknown_type() {
  return fail(ErrorCode::kUnsupported,
              "only integers of 8 to 32 bits and floating-point voxels are supported");
}

tl::unexpected<Error> damaged_image() {
  return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
}

}  // namespace diaphane::ingest
