#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volume/alignment.h"
#include "volume/oblique.h"
#include "volume/slices.h"

namespace diaphane::volume {

/// The centres of the pixels of a slice, in world coordinates of its volume (slices.h).
struct PixelGrid {
  std::uint32_t columns = 0, rows = 0;
  std::array<double, 3> first{}, right{}, down{};
};
PixelGrid pixels_of(const SliceStack& stack, std::uint32_t index);
PixelGrid pixels_of(const ObliqueSlice& slice);

/// Returns the values of a second scan at the pixels of a slice of the first scan, by trilinear
/// interpolation, rounded. Pixels outside the second scan are kBlank, and so are those that are
/// kBlank in `shown`, the values of the first scan. Of a slab, the middle plane is sampled.
std::vector<std::int16_t> second_slice(const Header& first, const PixelGrid& pixels,
                                       const Volume& second, const Matrix& to_first,
                                       std::span<const std::int16_t> shown);

}  // namespace diaphane::volume
