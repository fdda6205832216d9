#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/dicom/slice.h"
#include "ingest/dicom/stack.h"
#include "volume/volume.h"

namespace diaphane::dicom {

/// Whether the slices of one series are a volume, and which.
struct Assessment {
  bool suitable = false;
  std::string code;  ///< why not: "too_few_slices", "tilted", ... stable, for programs
  std::string text;  ///< why not: a sentence for the person
  std::vector<std::string> repairs;  ///< what was mended or left out, in words

  // With `suitable`:
  std::vector<std::size_t> order;  ///< indices of the slices kept, in the order of the volume's z
  /// The volume's slices, where they are not those of `order` as they are: see Stack::sources; and
  /// where their first pixel lies in the first slice's plane, in pixels along row and column.
  std::vector<Source> sources;
  std::array<double, 2> corner{};
  double unit = 0;  ///< the value of 1 where each slice has a scale of its own (to_values); else 0
  std::array<std::uint32_t, 3> size{};  ///< columns, rows, slices
  std::array<double, 3> spacing{};      ///< mm
  std::array<double, 9> direction{};    ///< as volume::Header::direction
  std::array<double, 3> origin{};       ///< mm (LPS), the centre of voxel 0, 0, 0; never stored
  volume::Modality modality = volume::Modality::kOther;
  double window_center = 0, window_width = 0;
};

/// Bounds of what is taken for a volume (design: ingest, "Cases and the right result").
inline constexpr std::size_t kFewestSlices = 16;
inline constexpr double kShortestStack = 20;   ///< mm
inline constexpr double kSteepestShear = 0.1;  ///< degrees between the stack and the slices' normal
inline constexpr double kSteepestTilt = 45;    ///< degrees; no gantry tilts further than 30
inline constexpr double kMostMissing = 0.05;   ///< share of the slices that are filled in
inline constexpr std::size_t kLargestGap = 3;  ///< distances from slice to slice
inline constexpr double kMostVarying = 8;     ///< largest distance from slice to slice by the least
inline constexpr double kJitterMm = 0.01;     ///< a slice's distance from its place: this,
inline constexpr double kJitterShare = 0.02;  ///< or this share of the spacing

/// Judges the slices of one series (all of one SeriesInstanceUID), in any order, and plans their
/// volume. Order and spacing come from positions along the slices' normal alone. What cannot be
/// made a stack of original CT, MR or PT slices is refused in words; never is a volume given whose
/// shape could be wrong. Pure. `most_voxels`: more is refused ("over_quota").
Assessment classify(const std::vector<Slice>& slices, std::uint64_t most_voxels);

/// "axial", "coronal", "sagittal" or "oblique", of a volume's direction.
std::string plane_name(const std::array<double, 9>& direction);

}  // namespace diaphane::dicom
