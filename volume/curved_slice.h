#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "volume/curve.h"
#include "volume/label_slice.h"
#include "volume/oblique.h"
#include "volume/second_slice.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// A slice that is straightened along a curve (curve.h), or a slab around it: a curved planar
/// reformation. The centre of pixel (column, row) lies at arc length column * pixel, and across the
/// curve by (row - (rows - 1) / 2) * pixel.
struct CurvedSlice {
  std::uint32_t id = 0;  ///< chosen by the viewer who requests it
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::vector<Vector> points;  ///< mm in world coordinates
  double pixel = 0;            ///< mm from one pixel to the next in both directions
  double angle =
      0;  ///< degrees by which rows are turned about the curve, from `across` of its frame
  double thickness = 0;  ///< mm; 0 means a plane
  Projection projection = Projection::kMean;

  bool operator==(const CurvedSlice&) const = default;
};

/// Returns kInvalid and the field if numbers are not finite or out of range, if there is no curve
/// through the points, if the slice is longer than the curve, or if it needs more than
/// kMostSamples.
Result<void> check(const Header& header, const CurvedSlice& slice);

/// Returns the number of columns that show a whole curve, or 0 if there is no such number.
std::uint32_t columns_along(const std::vector<Vector>& points, double pixel);

/// Returns the number of samples of a slice. Precondition: check() has accepted it.
std::uint64_t samples_of(const Header& header, const CurvedSlice& slice);

/// Returns each column as an oblique slice that is one pixel wide, so that both kinds of slices are
/// sampled alike. Precondition: check() has accepted the slice.
std::vector<ObliqueSlice> columns_of(const CurvedSlice& slice);

/// Samples the slice like sample() and sample_clipped() in oblique.h. Precondition: check() has
/// accepted it.
std::vector<std::int16_t> sample(const Volume& volume, const CurvedSlice& slice);
std::vector<std::int16_t> sample_clipped(const Volume& volume, const CurvedSlice& slice,
                                         const KeptVoxels& kept);
/// Like labels_of_slice() in label_slice.h.
std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const CurvedSlice& slice,
                                          const ClippedSlice* clipped = nullptr);
/// Like second_slice() in second_slice.h.
std::vector<std::int16_t> second_slice(const Header& first, const CurvedSlice& slice,
                                       const Volume& second, const Matrix& to_first,
                                       std::span<const std::int16_t> shown);

}  // namespace diaphane::volume
