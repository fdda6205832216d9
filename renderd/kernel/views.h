#pragma once

#include <cstdint>

#include "renderd/kernel/method.h"
#include "renderd/math/tone_curve.h"
#include "renderd/math/vector.h"

// The data that a kernel reads, as plain views without ownership or containers. Their pointers
// refer to memory of the host or of the device, wherever the kernel runs.
//
// All coordinates in a kernel are in the *volume's frame*: millimetres along the voxel axes, with
// the origin at the corner of voxel (0,0,0). Preparation transforms camera and lights into it once,
// so that a multiplication by the inverse spacing converts millimetres to voxel indices. Distances
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
/// x fastest, arithmetic in fp32. This is the reference way to read a volume. An engine may use a
/// type of its own with the same at().
struct LinearVolume {
  const std::int16_t* voxels;
  Int3 size;

  /// Returns the interpolated value at `p`, in voxel indices.
  HOST_DEVICE float at(Float3 p) const;
  /// Returns the smallest and largest value at the eight corners of a cell between voxel centres
  /// (VoxelWalk).
  HOST_DEVICE ValueSpan corner_range(Int3 cell) const;

  // The exact walk reads the cells between voxel centres through the functions below.
  /// Data that an engine looks up once for all cells of a brick; empty here.
  struct Brick {};
  HOST_DEVICE Brick brick(std::int32_t /*index*/) const { return {}; }
  HOST_DEVICE Corners corners(Int3 cell, Brick brick) const;
  HOST_DEVICE CornerRange corner_values(Int3 cell, Brick brick) const;
};

/// Extinction and colour by value, baked to tables of `count` >= 2 nodes and interpolated linearly.
struct TransferView {
  /// Extinction per mm. Rows of `count` maxima follow: entry i of row r (this table is row 0) is
  /// the largest of the 2^r nodes from node i on.
  const float* extinction;
  /// Sum over the channels of opacity times albedo, and in w the sum of opacities. The mean colour
  /// is xyz / w. Both sums can be interpolated without darkening where a channel begins (thesis
  /// 3.1.1).
  const Float4* colour;
  float scale, offset;  ///< node = value * scale + offset
  float margin;         ///< nodes by which rounding may put a value outside the range of its voxels
  std::int32_t count;
  /// Only with Feature::kGloss: sums over the channels of opacity times specular reflectance, and
  /// in w of opacity times gloss. Divide by the w of `colour` for means.
  const Float4* gloss = nullptr;
  /// Only with Feature::kEmission: sum over the channels of opacity times emission, and in w the
  /// sum of opacities.
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
  Box occupied;  ///< encloses all cells whose majorant is not 0; low == high if there are none
};

/// A linear piece of the extinction as a function of the value, from `begin` to `end`. `extinction`
/// is per mm at `begin`.
struct alignas(16) ExtinctionPiece {
  float begin, extinction, slope, end;
};

/// The kinds of hits of the exact walk. The first kIndirect kinds send a ray to a light by the
/// Strategy of the same number (direct.h); kIndirect continues a path.
inline constexpr int kIndirect = 4;
inline constexpr int kHitKinds = 5;

/// Edge of a brick in cells between voxel centres, a power of two.
inline constexpr int kBrickShift = 2;
inline constexpr int kBrickSize = 1 << kBrickShift;

inline constexpr std::int32_t kOutside = 255;  ///< value of ExactView::skips in the rim

/// Layout of an array of bricks with a rim of one brick around it.
struct BrickArray {
  std::int32_t row, slice, count;
  std::int32_t first;  ///< index of brick (0, 0, 0)

  HOST_DEVICE explicit BrickArray(Int3 bricks)
      : row(bricks.x + 2),
        slice(row * (bricks.y + 2)),
        count(slice * (bricks.z + 2)),
        first(1 + row + slice) {}
  HOST_DEVICE std::int32_t index(Int3 brick) const {
    return first + brick.x + row * brick.y + slice * brick.z;
  }
};

/// Data of the exact walk other than the voxels.
struct ExactView {
  const ExtinctionPiece* pieces;  ///< in order of value
  /// For each voxel value from `first_value` on, the index of the piece that contains it.
  const std::uint16_t* piece_of;
  std::int32_t piece_count, first_value, last_value;
  ExtinctionPiece only;  ///< the first piece, and the only one without Feature::kCurves
  Int3 size;             ///< size of the volume in voxels; there is one more cell along each axis
  /// The array of bricks has a rim of one brick around it, x fastest. Brick (x, y, z), from -1 on,
  /// is at x + brick_row y + brick_slice z, relative to brick (0, 0, 0).
  std::int32_t brick_row, brick_slice;
  std::int32_t brick_count;  ///< including the rim
  /// One entry per brick for each of 8 octants (bit 0 is set if x increases along the ray, and so
  /// on); octants are `brick_count` entries apart. An entry is 0 if the brick may contain matter.
  /// Otherwise it is the edge, in bricks, of an empty cube that starts with this brick and extends
  /// in the octant's direction. Entries of the rim are kOutside. Points at brick (0, 0, 0).
  const std::uint8_t* skips;
  /// Number of strata of the ray's opacity for each kind of hit. A camera ray has at most one
  /// collision of the kind per stratum.
  std::int32_t strata[kHitKinds];

  /// Returns the index of the piece that contains `value`.
  HOST_DEVICE std::int32_t piece_at(float value) const {
    const float v =
        min(max(value, static_cast<float>(first_value)), static_cast<float>(last_value));
    std::int32_t piece = piece_of[static_cast<std::int32_t>(floorf(v)) - first_value];
    while (piece + 1 < piece_count && pieces[piece + 1].begin <= v)
      ++piece;  // there may be several pieces between two integers
    return piece;
  }
};

enum class LightShape : std::uint32_t { kRectangle, kDisk, kSphere };
inline constexpr std::uint32_t kNoTexture = 0xffffffffu;

/// A light of finite size, or a point. Rectangles and disks shine only to the side of `normal`, and
/// spheres shine outwards.
///
/// A rectangle has the points corner + a u + b v, with a and b in [0, 1]. For a disk, `corner` is
/// the centre, and u and v are the radii to the right and up in its texture. For a sphere, `corner`
/// is the centre, and u and v are the radii to the right of the texture's middle and to the middle.
/// Disks and spheres of radius 0 (u and v are 0) are points.
struct AreaLight {
  Float3 corner, u, v;
  Float3 normal;  ///< unit, along cross(u, v); for a sphere, its upper pole
  float area;     ///< mm^2; for a sphere, as seen from a distance, pi r^2; for a point, 1
  Float3 radiance;
  /// The light is chosen for u from the previous light's `cumulative` up to its own, which is
  /// excluded. `probability` is the difference of the two.
  float probability, cumulative;
  LightShape shape;
  std::uint32_t texture;  ///< index in LightsView::textures, or kNoTexture
  /// Above 0, the texture is projected to a plane at the distance `focus`, where it is
  /// 1 / `per_mm` wide and high.
  float per_mm, focus;
};

/// A picture that multiplies a light's radiance: linear, interpolated between texel centres.
struct LightTexture {
  std::uint32_t first_texel;  ///< index in LightsView::texels; rows from the top
  std::uint32_t first_row;    ///< index in LightsView::rows
  std::int32_t width, height;
};

/// An environment light with a texture.
struct EnvironmentMap {
  Float3 right, middle, up;  ///< unit; `middle` is the direction of the texture's middle
  Float3 radiance;
  float probability, cumulative;  ///< as in AreaLight
  std::uint32_t texture;
};

struct LightsView {
  const AreaLight* area;
  std::uint32_t count;         ///< number of entries in `area`
  Float3 environment;          ///< sum of the radiances of all environment lights without a texture
  std::uint32_t map_count;     ///< number of entries in `maps`
  const EnvironmentMap* maps;  ///< environment lights with a texture
  const LightTexture* textures;
  /// xyz is the colour. w is the probability that a direction sampled in this row of a
  /// latitude-longitude map lies in this texel or before it.
  const Float4* texels;
  const float* rows;  ///< probability that a sampled direction lies in this row or above it
  bool maps_visible;  ///< whether camera rays see the maps
};

/// A pinhole, a thin lens or parallel rays in one form. A ray starts not at the eye but in the
/// plane at depth `near` along the view axis, just before the box, so that its coordinates remain
/// small even if the eye is far away.
struct CameraView {
  Float3 start;      ///< start of the ray through the middle, mm in the volume's frame
  Float3 forward;    ///< unit
  Float3 right, up;  ///< to the edges of the picture, at depth 1; parallel rays: at any depth, mm
  float near;        ///< factor of right and up at the start: its depth in mm; parallel rays: 1
  float spread;      ///< factor of right and up per unit of depth: 1; parallel rays: 0
  /// The vectors from the centre to the edge of the lens (Feature::kLens), mm. A ray is shifted by
  /// the fraction `lens_at_start` of them at its start, and by `lens_bend` less per unit of depth,
  /// so that no shift is left in the plane of focus.
  Float3 lens_right, lens_up;
  float lens_at_start, lens_bend;
};

/// The points p in voxel indices with dot(normal, p) <= most; both sides are in mm.
struct HalfSpace {
  Float3 normal;  ///< scaled to apply to voxel indices
  float most;
};

/// The clip keeps the points that lie in all half-spaces. These are bounded by the six faces of the
/// clip box and by the free planes. Half-spaces that contain the whole volume are omitted.
struct ClipView {
  static constexpr std::uint32_t kMost = 12;
  HalfSpace kept[kMost];
  std::uint32_t count;        ///< number of half-spaces that cut camera rays
  std::uint32_t light_count;  ///< number of half-spaces that cut light: all or none
};

/// How the matter of a label is shown.
struct alignas(16) LabelLook {
  Float3 colour;  ///< albedo; x < 0 keeps the albedo of the matter
  float opacity;  ///< factor of the extinction, in [0, 1]
};
inline constexpr LabelLook kUnchangedLook{{-1.0f, -1.0f, -1.0f}, 1.0f};

/// Labels of the voxels (Feature::kLabels).
struct LabelsView {
  const std::uint8_t* voxels;  ///< label per voxel, x fastest; null if there are no labels
  const LabelLook* looks;      ///< by label; entry 0 is for voxels of no label
};

/// A sphere in which matter is tinted (Feature::kLabels).
struct HighlightView {
  Float3 centre;         ///< mm in the volume's frame
  float squared_radius;  ///< mm^2
  Float3 colour;         ///< albedo
  float strength;        ///< share of `colour`, in [0, 1]; 0: no highlight
};

/// An affine map of voxel indices.
struct AffineMap {
  Float3 rows[3];
  Float3 shift;
};

/// The second scan of a scene (Feature::kOverlay).
template <typename Volume>
struct OverlayView {
  Volume volume;
  TransferView transfer;
  AffineMap map;           ///< from voxel indices of the first scan to those of the second
  const float* majorants;  ///< of the second scan's extinction, by macrocell of the first scan
  float step;              ///< smallest spacing of the second scan, mm
  float surfaces;          ///< as SceneView::surfaces, for the second scan
  float per_extinction;    ///< as SlicesView::per_extinction, for the second scan
  /// Factors of the extinctions of both scans: 1 and 0 if the scene has no second scan, but the
  /// kernel has the feature.
  float first_share, second_share;
  float first_in_slices, second_in_slices;  ///< factors of the opacities in slices
  bool split;          ///< paths left of `split_column` meet the first scan, the others the second
  float split_column;  ///< in the whole picture
};

struct SlicesView {
  Float3 position;       ///< position along each voxel axis, voxel indices; < 0: no slice
  bool coloured;         ///< coloured by the transfer function; false: grey by the window
  float black_value;     ///< voxel value that is black
  float per_value;       ///< grey level per voxel value above `black_value`
  float per_extinction;  ///< opacity per extinction (mm)
  ToneCurve curve;       ///< of the display
  float white;           ///< 1 / 2^exposure, which cancels the exposure of the display
};

/// Which numbers of the random sequence the samples of the film use. If several devices average one
/// picture, device `part` of `parts` uses every parts-th pair. Together they draw the same samples
/// as one device and keep the even distribution of its points. Pairs are used because the two
/// samples of a pair belong to the two halves of the film.
struct SampleNumbers {
  std::uint32_t part = 0, parts = 1;

  HOST_DEVICE std::uint64_t of(std::uint64_t sample) const {
    return 2 * ((sample >> 1) * parts + part) + (sample & 1);
  }
};

/// Everything that one sample of one pixel depends on. `Volume` has the members of LinearVolume.
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
  LabelsView labels;
  HighlightView highlight;
  OverlayView<Volume> overlay;
  float phase_g;
  /// A place where the extinction has the gradient G (per mm^2) is a surface with the probability
  /// 1 - exp(-|G| surfaces). Unit mm^2; 0 means never, infinity wherever there is a gradient.
  float surfaces;
  std::uint32_t bounces;        ///< maximum number of collisions of a path, at least 1
  bool roulette;                ///< paths of low weight may end early; unbiased either way
  Float3 escape;                ///< radiance of a camera ray that leaves the volume
  Float3 escape_edge;           ///< added to `escape` in proportion to CameraRay::off_centre
  std::uint32_t width, height;  ///< of the film
  std::uint32_t first_row, picture_height;  ///< of the picture of which the film is a band
  std::uint64_t seed;
  /// Number of the first sample in the random stream, which keeps the samples of devices disjoint.
  std::uint64_t first_sample;
  std::uint64_t stream;  ///< stream of the low-discrepancy points, a hash of the two above
  /// Use no low-discrepancy points, for comparison (Method::low_discrepancy).
  bool independent_points;
  Mis mis;
  Walk walk;
  SampleNumbers numbers;

  /// Returns the index of a pixel in the whole picture, on which its random numbers depend.
  HOST_DEVICE std::uint32_t pixel(std::uint32_t x, std::uint32_t y) const {
    return x + width * (first_row + y);
  }
};

}  // namespace diaphane::render
