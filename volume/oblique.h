#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// How a slab combines the samples along its normal.
enum class Projection { kMean, kMaximum, kMinimum };

/// A plane in any direction, or a slab around it, in world coordinates (slices.h). The centre of
/// pixel (column, row) is first + column * right + row * down.
struct ObliqueSlice {
  std::uint32_t id = 0;  ///< chosen by the viewer who requests it
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  Vector first{};
  Vector right{};        ///< mm from one pixel to the next
  Vector down{};         ///< perpendicular to `right`
  double thickness = 0;  ///< mm; 0 means a plane
  Projection projection = Projection::kMean;

  bool operator==(const ObliqueSlice&) const = default;
};

inline constexpr std::uint32_t kMostObliqueSide = 2048;
/// Maximum number of samples, which take about half a second of a core.
inline constexpr std::uint64_t kMostSamples = std::uint64_t{1} << 25;

/// Returns the number of samples per pixel. Samples in a slab are at most the volume's smallest
/// spacing apart, and the outermost ones lie on its two faces.
std::uint64_t layers_of(const Header& header, double thickness);
/// Returns the number of samples of a slice. Precondition: check() has accepted it.
std::uint64_t samples_of(const Header& header, const ObliqueSlice& slice);

/// Returns the unit vector right x down. Precondition: check() has accepted the slice.
Vector normal_of(const ObliqueSlice& slice);

/// Returns kInvalid and the field if numbers are not finite or out of range, if the sides are not
/// perpendicular, or if the slice needs more than kMostSamples.
Result<void> check(const Header& header, const ObliqueSlice& slice);

/// Samples the slice with trilinear interpolation between the centres of voxels, rounded to whole
/// numbers. Between the outermost centres and the border of the volume, the outermost voxels
/// continue. Samples outside the volume have no value: a slab leaves them out, and a pixel with
/// none has the header's minimum. Precondition: check() has accepted the slice.
std::vector<std::int16_t> sample(const Volume& volume, const ObliqueSlice& slice);
/// Samples only the kept voxels. A sample that a hidden voxel would contribute to has no value, and
/// a pixel with none is kBlank.
std::vector<std::int16_t> sample_clipped(const Volume& volume, const ObliqueSlice& slice,
                                         const KeptVoxels& kept);

}  // namespace diaphane::volume
