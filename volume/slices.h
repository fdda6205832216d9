#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/result.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// Across which of the patient's axes.
enum class Plane { kAxial, kCoronal, kSagittal };
inline constexpr std::array kPlanes{Plane::kAxial, Plane::kCoronal, Plane::kSagittal};

/// Slices of a volume along the patient's axes, as a radiologist sees them: the patient's right at
/// the left of the picture (axial, coronal), the front at the left (sagittal), axial from the feet.
/// World as in scenes (api/proto/scene.proto): mm, LPS, origin at the centre of the volume's box.
struct SliceStack {
  Plane plane = Plane::kAxial;
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t slices = 0;
  std::array<double, 3> first{};  ///< the centre of the first slice's upper left pixel
  std::array<double, 3> right{};  ///< mm from a pixel to the next; along one axis each
  std::array<double, 3> down{};
  std::array<double, 3> next{};  ///< from a slice to the next: to the head, the back, the left

  std::size_t pixels() const { return std::size_t{columns} * rows; }
};

/// A volume lies along the patient's axes when its own deviate by no more than this (sine).
inline constexpr double kAligned = 1e-4;
/// Columns, rows and slices of an oblique volume's stack, at most; then steps are longer.
inline constexpr std::uint32_t kMostOblique = 2048;

/// Of a volume along the patient's axes a pixel is a voxel. Of an oblique one the slices cover its
/// whole box, and along each axis the step is what it takes to pass one voxel.
SliceStack plan_stack(const Header& header, Plane plane);

/// Slice `index` of the stack, rows from the top: each pixel has the value of the voxel in which
/// its centre lies, and the header's minimum outside of the volume. No value is made up by
/// interpolation. kInvalid: there is no such slice. Precondition: the stack is this volume's.
Result<std::vector<std::int16_t>> slice_of(const Volume& volume, const SliceStack& stack,
                                           std::uint32_t index);

/// The value of every pixel of a clipped slice that shows nothing. No voxel's value is told by it.
inline constexpr std::int16_t kBlank = -32768;
/// The same of the kept voxels alone; all other pixels are kBlank, those outside of the volume too.
Result<std::vector<std::int16_t>> clipped_slice_of(const Volume& volume, const SliceStack& stack,
                                                   std::uint32_t index, const KeptVoxels& kept);

}  // namespace diaphane::volume
