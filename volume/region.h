#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::volume {

using Vector = std::array<double, 3>;

/// The part of a volume to keep: a box along the patient's axes and up to six planes, in world
/// coordinates of scenes (api/proto/scene.proto, Clip: millimetres, LPS, origin at the centre of
/// the volume's box). A picture that is clipped with the same region shows exactly the part that is
/// kept.
struct Region {
  Vector low{}, high{};
  struct Plane {
    Vector point{};
    Vector normal{};  ///< points to the removed side; any length except 0
  };
  std::vector<Plane> planes;
};

inline constexpr std::size_t kMostPlanes = 6;
/// Minimum number of voxels along each axis of the result, because a smaller volume shows nothing.
inline constexpr std::uint32_t kLeastSide = 8;

/// Parses {"box": {"low": [x,y,z], "high": [x,y,z]}, "planes": [{"point": [x,y,z], "normal":
/// [x,y,z]}]}. Returns kInvalid with the field for unknown fields, numbers that are not finite, low
/// >= high, more than six planes, or a normal of length zero.
Result<Region> region_from_json(const std::string& text);
std::string to_json(const Region& region);

/// The voxels whose centres lie behind all of the given planes, including centres exactly on a
/// plane.
class KeptVoxels {
 public:
  KeptVoxels(const Header& header, std::span<const Region::Plane> planes);
  /// Returns false for every voxel if a plane is invalid (not finite, or without a normal).
  bool keeps(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;

 private:
  struct Side {
    Vector slope{};        // mm per index step
    double at_origin = 0;  // mm, signed distance of the centre of voxel (0, 0, 0)
  };
  std::vector<Side> sides_;  // affine functions of the index; a voxel is kept if none is above 0
};
/// Returns the six faces of a box along the patient's axes.
std::vector<Region::Plane> faces_of(const Vector& low, const Vector& high);

/// The geometry of a cut. A voxel is kept if its centre lies within the region or on its border, so
/// at most half a voxel beyond the border is kept.
struct Cut {
  std::array<std::uint32_t, 3> low{};  ///< index in the old volume of the new one's first voxel
  std::array<std::uint32_t, 3> size{};
  Vector shift{};          ///< mm; world position p of the old volume is p - shift in the new one
  std::int16_t air = 0;    ///< value that overwrites removed voxels
  std::uint64_t kept = 0;  ///< number of kept voxels
};

/// Computes the cut. Returns kInvalid if fewer than kLeastSide voxels are left along an axis that
/// had as many, or if a shorter axis would become shorter.
Result<Cut> plan_cut(const Header& header, const Region& region);

/// Returns the header of the volume after a cut. measure() fills minimum, maximum and percentiles,
/// and write() fills the hash.
Header after(const Header& header, const Cut& cut);

/// Computes one slice of the new volume from slice z = cut.low[2] + `slice` of the old one: kept
/// voxels are unchanged, and all others are air. Precondition: the sizes match the header and the
/// cut.
void cut_slice(const Header& header, const Region& region, const Cut& cut, std::uint32_t slice,
               std::span<const std::int16_t> from, std::span<std::int16_t> to);

/// Cuts a whole volume in memory and measures the result, which has no hash yet. Returns the errors
/// of plan_cut().
Result<Volume> cut_volume(const Volume& volume, const Region& region);

}  // namespace diaphane::volume
