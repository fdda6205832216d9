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

/// What is kept of a volume: a box along the patient's axes and up to six planes, in the world of
/// scenes (api/proto/scene.proto, Clip: millimetres, LPS, origin at the centre of the volume's
/// box), so that what a clipped picture shows is what is kept.
struct Region {
  Vector low{}, high{};
  struct Plane {
    Vector point{};
    Vector normal{};  ///< points to the side that goes; of any length but 0
  };
  std::vector<Plane> planes;
};

inline constexpr std::size_t kMostPlanes = 6;
/// Voxels along each axis that must be left: a picture of less is none.
inline constexpr std::uint32_t kLeastSide = 8;

/// {"box": {"low": [x,y,z], "high": [x,y,z]}, "planes": [{"point": [x,y,z], "normal": [x,y,z]}]}.
/// kInvalid, with the field, for anything else: unknown fields, numbers that are not finite,
/// low >= high, more planes than six, a normal without length.
Result<Region> region_from_json(const std::string& text);
std::string to_json(const Region& region);

/// The voxels behind all of some planes, by their centres (a border exactly at a centre keeps it).
class KeptVoxels {
 public:
  KeptVoxels(const Header& header, std::span<const Region::Plane> planes);
  /// Not for a plane that is none: what has no number, or no normal, keeps nothing.
  bool keeps(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;

 private:
  struct Side {
    Vector slope{};        // mm an index step
    double at_origin = 0;  // mm, of the centre of voxel (0, 0, 0)
  };
  std::vector<Side> sides_;  // affine functions of an index; kept is what has none above 0
};
/// Of a box along the patient's axes.
std::vector<Region::Plane> faces_of(const Vector& low, const Vector& high);

/// Which voxels go. A voxel is kept when its centre lies within the region (its border included):
/// at most half a voxel beyond the border is kept, and nothing further.
struct Cut {
  std::array<std::uint32_t, 3> low{};  ///< the first voxel of the new volume, in the old one
  std::array<std::uint32_t, 3> size{};
  Vector shift{};          ///< mm: what was at world p is at p - shift in the new volume's world
  std::int16_t air = 0;    ///< overwrites what goes
  std::uint64_t kept = 0;  ///< voxels
};

/// kInvalid when less than kLeastSide voxels are left along an axis.
Result<Cut> plan_cut(const Header& header, const Region& region);

/// The header of what a cut leaves; minimum, maximum, percentiles and hash are for measure() and
/// write() to fill.
Header after(const Header& header, const Cut& cut);

/// One slice of the new volume from the same slice (z = cut.low[2] + `slice`) of the old one:
/// kept voxels bit by bit, air elsewhere. Precondition: sizes as header and cut say.
void cut_slice(const Header& header, const Region& region, const Cut& cut, std::uint32_t slice,
               std::span<const std::int16_t> from, std::span<std::int16_t> to);

/// The same on a whole volume in memory: measured, without a hash.
Result<Volume> cut_volume(const Volume& volume, const Region& region);

}  // namespace diaphane::volume
