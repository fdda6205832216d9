#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/result.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// The anatomical plane of a slice.
enum class Plane { kAxial, kCoronal, kSagittal };
inline constexpr std::array kPlanes{Plane::kAxial, Plane::kCoronal, Plane::kSagittal};

/// Slices of a volume along the patient's axes in radiological orientation: the patient's right is
/// at the left of the picture (axial, coronal), the front is at the left (sagittal), and axial
/// slices are seen from the feet. World coordinates are those of scenes (api/proto/scene.proto):
/// mm, LPS, origin at the centre of the volume's box.
struct SliceStack {
  Plane plane = Plane::kAxial;
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t slices = 0;
  std::array<double, 3> first{};  ///< centre of the upper left pixel of the first slice
  std::array<double, 3> right{};  ///< mm from one pixel to the next, along one axis each
  std::array<double, 3> down{};
  std::array<double, 3> next{};  ///< mm from one slice to the next: to the head, back or left

  std::size_t pixels() const { return std::size_t{columns} * rows; }
};

/// A volume counts as aligned if its axes deviate from the patient's by at most this (sine).
inline constexpr double kAligned = 1e-4;
/// Maximum columns, rows and slices of an oblique volume's stack. A larger volume gets longer
/// steps.
inline constexpr std::uint32_t kMostOblique = 2048;

/// Plans the slices of a volume. In an aligned volume, each pixel is one voxel. In an oblique one,
/// the slices cover the whole box, and a step along an axis passes at most one voxel, unless the
/// stack would exceed kMostOblique.
SliceStack plan_stack(const Header& header, Plane plane);

/// Returns slice `index` of the stack, with rows from the top. Each pixel has the value of the
/// voxel that contains its centre, or the header's minimum outside the volume. Values are never
/// interpolated. Returns kInvalid if there is no such slice. Precondition: the stack was planned
/// for this volume.
Result<std::vector<std::int16_t>> slice_of(const Volume& volume, const SliceStack& stack,
                                           std::uint32_t index);

/// Returns the value of pixels outside the volume: the header's minimum.
std::int16_t value_outside(const Header& header);

/// The value of pixels in a clipped slice that show nothing, so that they reveal no voxel.
inline constexpr std::int16_t kBlank = -32768;
/// Returns the same slice with only the kept voxels. All other pixels are kBlank, also those
/// outside the volume.
Result<std::vector<std::int16_t>> clipped_slice_of(const Volume& volume, const SliceStack& stack,
                                                   std::uint32_t index, const KeptVoxels& kept);

}  // namespace diaphane::volume
