#pragma once

#include <cstdint>

#include "renderd/kernel/method.h"
#include "renderd/math/vector.h"

// What a kernel reads, as plain views: no ownership, no containers, the pointers are the executor's
// (host or device).
//
// Space: everything in a kernel is in the *volume's frame*: millimetres along the voxel axes,
// origin at the corner of voxel (0,0,0). Preparation rotates camera and lights into it once, so a
// step from millimetres to voxel indices is a multiplication by the inverse spacing. Distances
// along a ray are in millimetres.

namespace diaphane::render {

/// Edge of a macrocell in voxels, a power of two.
inline constexpr int kCellShift = 3;
inline constexpr int kCellSize = 1 << kCellShift;

struct Corners;      // exact_cell.h
struct CornerRange;  // exact_cell.h

/// Voxel values from `low` to `high`.
struct ValueSpan {
  float low, high;
};

/// Trilinear interpolation between voxel centres (index + 1/2), clamped at the edges; int16 voxels,
/// x fastest, arithmetic in fp32. The reference way to read a volume; an engine may bring its own
/// type with the same at().
struct LinearVolume {
  const std::int16_t* voxels;
  Int3 size;

  /// `p` in voxel indices.
  HOST_DEVICE float at(Float3 p) const;
  /// Smallest and largest of the eight corners of a cell between voxel centres (VoxelWalk).
  HOST_DEVICE ValueSpan corner_range(Int3 cell) const;

  // Of cells between voxel centres (ExactWalk).
  /// What an engine looks up once for all cells of a brick: nothing here.
  struct Brick {};
  HOST_DEVICE Brick brick(std::int32_t /*index*/) const { return {}; }
  HOST_DEVICE Corners corners(Int3 cell, Brick brick) const;
  HOST_DEVICE CornerRange corner_values(Int3 cell, Brick brick) const;
};

/// Extinction and colour by value, baked to tables of `count` >= 2 nodes and interpolated linearly.
struct TransferView {
  /// Per mm; rows of `count` maxima follow: row r (this table is row 0) holds the largest of the
  /// 2^r nodes from each node on.
  const float* extinction;
  /// Sum over the channels of opacity times albedo, and in w the sum of opacities: the mean colour
  /// is xyz / w, and both sums interpolate without darkening where a channel begins (thesis 3.1.1).
  const Float4* colour;
  float scale, offset;  ///< node = value * scale + offset
  float margin;         ///< nodes that rounding may put a value beyond its voxels'
  std::int32_t count;
  /// Of surfaces, only where the scene has them (Feature::kGloss): sums over the channels of
  /// opacity times specular reflectance, and in w of opacity times gloss. Means by `colour`'s w.
  const Float4* gloss = nullptr;
  /// Only where matter glows (Feature::kEmission): sum of opacity times emission, and in w the sum
  /// of the opacities.
  const Float4* emission = nullptr;
};

/// Bounds of the extinction (per mm) anywhere in a macrocell.
struct CellBounds {
  float minorant, majorant;
};

/// Axis-aligned box in voxel indices.
struct Box {
  Float3 low, high;
};

struct GridView {
  const CellBounds* cells;  ///< x fastest
  Int3 size;                ///< in cells
  Box occupied;  ///< around all cells whose majorant is not 0; low == high when there are none
};

/// A part of the extinction function in which it is linear in the value: from `begin` to `end`,
/// `extinction` (per mm) at `begin`.
struct alignas(16) ExtinctionPiece {
  float begin, extinction, slope, end;
};

/// What a collision of the exact walk is for: a ray to a light by one of the strategies of
/// direct.h, or a path that goes on.
inline constexpr int kOnwards = 4;
inline constexpr int kHitKinds = 5;

/// Edge of a brick in cells between voxel centres, a power of two.
inline constexpr int kBrickShift = 2;
inline constexpr int kBrickSize = 1 << kBrickShift;

inline constexpr std::int32_t kOutside = 255;  ///< ExactView::skips

/// An array of bricks with a rim.
struct BrickArray {
  std::int32_t row, slice, count;
  std::int32_t first;  ///< brick (0, 0, 0)

  HOST_DEVICE explicit BrickArray(Int3 bricks)
      : row(bricks.x + 2),
        slice(row * (bricks.y + 2)),
        count(slice * (bricks.z + 2)),
        first(1 + row + slice) {}
  HOST_DEVICE std::int32_t index(Int3 brick) const {
    return first + brick.x + row * brick.y + slice * brick.z;
  }
};

/// What the exact walk needs beside the voxels.
struct ExactView {
  const ExtinctionPiece* pieces;  ///< by rising value
  /// For each voxel value from `first_value` on: the piece in which it begins.
  const std::uint16_t* piece_of;
  std::int32_t piece_count, first_value, last_value;
  ExtinctionPiece only;  ///< the first: all of them without Feature::kCurves
  Int3 size;             ///< of the volume in voxels: one less than the cells along each axis
  /// Bricks lie in an array with a rim of one brick around, x fastest: brick (x, y, z), from -1 on,
  /// is x + brick_row y + brick_slice z from brick (0, 0, 0) on.
  std::int32_t brick_row, brick_slice;
  std::int32_t brick_count;  ///< with the rim
  /// For each of 8 octants (bit 0: the ray goes up x, ...), `brick_count` apart, and each brick: 0
  /// where something may be, else so many bricks along each axis in the octant's direction, this
  /// one included, are empty; kOutside in the rim. Points at brick (0, 0, 0).
  const std::uint8_t* skips;
  /// Collisions of one camera ray, by what they are for: so many strata of its opacity.
  std::int32_t strata[kHitKinds];

  /// The index of the piece in which `value` lies.
  HOST_DEVICE std::int32_t piece_at(float value) const {
    const float v =
        smaller(larger(value, static_cast<float>(first_value)), static_cast<float>(last_value));
    std::int32_t piece = piece_of[static_cast<std::int32_t>(floorf(v)) - first_value];
    while (piece + 1 < piece_count && pieces[piece + 1].begin <= v)
      ++piece;  // pieces between two integers
    return piece;
  }
};

enum class LightShape : std::uint32_t { kRectangle, kDisk, kSphere };
inline constexpr std::uint32_t kNoTexture = 0xffffffffu;

/// One-sided: it shines to the side of `normal`, a sphere outwards.
///
/// Rectangle: the points corner + a u + b v, a and b in [0, 1]. Disk: centre `corner`, u and v its
/// radii to the right and up in its texture. Sphere: centre `corner`, u and v its radii to the
/// right of the texture's middle and to the middle. Disk and sphere of radius 0 (u and v are 0) are
/// points.
struct AreaLight {
  Float3 corner, u, v;
  Float3 normal;  ///< unit, along cross(u, v); a sphere's upper pole
  float area;     ///< mm^2; a sphere's as seen from far off, pi r^2; a point's 1
  Float3 radiance;
  /// Picked for u in [cumulative of the one before, cumulative); `probability` is the difference.
  float probability, cumulative;
  LightShape shape;
  std::uint32_t texture;  ///< index in LightsView::textures, or kNoTexture
};

/// A picture that a light's radiance is multiplied by: linear, interpolated between texel centres.
struct LightTexture {
  std::uint32_t first_texel;  ///< index in LightsView::texels; rows from the top
  std::uint32_t first_row;    ///< index in LightsView::rows
  std::int32_t width, height;
};

/// An environment light with a texture.
struct EnvironmentMap {
  Float3 right, middle, up;  ///< unit; `middle` is the direction of the texture's middle
  Float3 radiance;
  float probability, cumulative;  ///< as AreaLight's
  std::uint32_t texture;
};

struct LightsView {
  const AreaLight* area;
  std::uint32_t count;         ///< of `area`
  Float3 environment;          ///< sum of the radiances of all environment lights without a texture
  std::uint32_t map_count;     ///< of `maps`
  const EnvironmentMap* maps;  ///< environment lights with a texture
  const LightTexture* textures;
  /// xyz: colour. w: probability, over the solid angle as a latitude-longitude map, that a
  /// direction drawn from this row lies in this texel or before it.
  const Float4* texels;
  const float* rows;  ///< probability that a direction drawn lies in this row or above it
  bool maps_seen;     ///< by camera rays
};

/// Pinhole, thin lens and parallel rays in one form. A ray begins in the plane at depth `near`
/// along the view axis, just before the box, not at the eye: its coordinates stay small however far
/// away the eye is.
struct CameraView {
  Float3 start;      ///< of the ray through the middle, mm in the volume's frame
  Float3 forward;    ///< unit
  Float3 right, up;  ///< to the picture's edges: at depth 1; parallel rays: at any depth, mm
  float near;    ///< what they are multiplied by at the start: its depth in mm; parallel rays: 1
  float spread;  ///< and per unit of depth: 1; parallel rays: 0
  /// Feature::kLens: to the lens's edge, mm; how much of it is left at the start, and how much is
  /// lost per unit of depth, so that nothing is left in the plane of focus.
  Float3 lens_right, lens_up;
  float lens_at_start, lens_bend;
};

/// Places p in voxel indices with dot(normal, p) <= most; both in mm.
struct HalfSpace {
  Float3 normal;  ///< so scaled that it takes voxel indices
  float most;
};

/// What is kept lies in all of them: the clip box's six faces and the free planes, without those
/// that cut nothing off the volume.
struct ClipView {
  static constexpr std::uint32_t kMost = 12;
  HalfSpace kept[kMost];
  std::uint32_t count;        ///< that cut camera rays
  std::uint32_t light_count;  ///< that cut light: all or none
};

struct SlicesView {
  Float3 position;       ///< across each voxel axis, voxel indices; < 0: none
  bool coloured;         ///< by the transfer function, else grey by the window
  float black_value;     ///< voxel value that is black
  float per_value;       ///< grey per voxel value above that
  float per_extinction;  ///< opacity per extinction (mm)
  float white;           ///< radiance that the display shows as white: 1 over 2^exposure
};

/// Which numbers of the random sequence the film's samples have. Of several devices that average
/// one picture, device `part` of `parts` takes every parts-th pair: together they draw what one
/// device would, and keep what its points are spread evenly for. Pairs, since the two samples of
/// one belong to the two halves.
struct SampleNumbers {
  std::uint32_t part = 0, parts = 1;

  HOST_DEVICE std::uint64_t of(std::uint64_t sample) const {
    return 2 * ((sample >> 1) * parts + part) + (sample & 1);
  }
};

/// All that one sample of one pixel depends on. `Volume` has the members of LinearVolume.
template <typename Volume>
struct SceneView {
  Volume volume;
  Float3 inverse_spacing;  ///< voxels per mm
  Float3 spacing;          ///< mm
  TransferView transfer;
  GridView grid;
  ExactView exact;
  LightsView lights;
  CameraView camera;
  ClipView clip;
  SlicesView slices;
  float phase_g;
  /// mm: a place where the extinction has the gradient G is a surface with probability
  /// 1 - exp(-|G| surfaces), G per mm^2. 0: never, infinity: wherever there is a gradient.
  float surfaces;
  std::uint32_t bounces;        ///< collisions of a path at most, from 1
  bool roulette;                ///< paths of little weight may end early; unbiased either way
  Float3 escape;                ///< radiance of a camera ray that leaves the volume
  std::uint32_t width, height;  ///< of the film
  std::uint32_t first_row, picture_height;  ///< of the picture that the film is a band of
  std::uint64_t seed;
  std::uint64_t first_sample;  ///< of the random stream: keeps the samples of devices apart
  std::uint64_t stream;        ///< of the low-discrepancy points: a hash of the two above
  bool independent_points;     ///< take none of those, for comparison (Method::low_discrepancy)
  Mis mis;
  Walk walk;
  SampleNumbers numbers;

  /// In the picture that the film is a band of: what a pixel's random numbers follow from.
  HOST_DEVICE std::uint32_t pixel(std::uint32_t x, std::uint32_t y) const {
    return x + width * (first_row + y);
  }
};

}  // namespace diaphane::render
