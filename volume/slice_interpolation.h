#pragma once

#include <cstdint>

#include "volume/volume.h"

namespace diaphane::volume {

/// Largest number of slices that refine_slices() makes of one, and the largest number of voxels
/// that it makes in all (256 MiB).
inline constexpr std::uint32_t kMaxRefinement = 8;
inline constexpr std::uint64_t kMaxRefinedVoxels = std::uint64_t{1} << 27;

/// Returns how many slices to render for each stored one. It is more than 1 where stored slices are
/// so far apart that a surface rendered from them has steps. Then the slices are about as far apart
/// as pixels are wide, within the limits above.
std::uint32_t refinement_of(const Header& header);

/// Divides each slice into `refinement` thinner ones, which fill the same box. The values between
/// two stored slices are interpolated along the motion between the two, not straight across: a
/// symmetric version of the method by Lucas and Kanade (1981) estimates in which direction the
/// anatomy continues from one slice to the next (compare Penney et al., "Registration-based
/// interpolation", IEEE TMI 23(7), 2004). No value lies outside the range of the stored ones. Uses
/// up to `threads` threads. Throws std::bad_alloc and then leaves the volume as it was.
void refine_slices(Volume& volume, std::uint32_t refinement, unsigned threads);

/// Returns the header that the volume had before refine_slices().
Header stored_header(const Header& header);

}  // namespace diaphane::volume
