#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/dicom/slice.h"
#include "ingest/dicom/stack.h"
#include "volume/volume.h"

namespace diaphane::dicom {

/// Whether the slices of one series form a volume, and how.
struct Assessment {
  bool suitable = false;
  std::string code;  ///< reason for refusal, stable, for programs: "too_few_slices", "tilted", ...
  std::string text;  ///< reason for refusal, a sentence for the person
  /// Corrections and omissions, in words. The page reads these sentences
  /// (frontend/src/scan/corrections.ts).
  std::vector<std::string> repairs;

  // The fields below are valid if `suitable`.
  /// Indices of the slices to keep, in the order of the volume's z, phase by phase.
  std::vector<std::size_t> order;
  std::vector<volume::Phase> phases;  ///< as volume::Header::phases
  /// Sources of the volume's slices if they are not the slices of `order` unchanged (see
  /// Stack::sources). `corner` is where their first pixel lies in the first slice's plane, in
  /// pixels along row and column.
  std::vector<Source> sources;
  std::array<double, 2> corner{};
  double unit = 0;  ///< unit of the values if each slice has its own scale (to_values), else 0
  std::array<std::uint32_t, 3> size{};  ///< columns, rows, slices of one phase
  std::array<double, 3> spacing{};      ///< mm
  std::array<double, 9> direction{};    ///< as volume::Header::direction
  std::array<double, 3> origin{};       ///< mm (LPS), the centre of voxel 0, 0, 0; never stored
  volume::Modality modality = volume::Modality::kOther;
  double window_center = 0, window_width = 0;  ///< as in Slice
};

/// Limits for what counts as a volume (design: ingest, "Cases and the right result").
inline constexpr std::size_t kFewestSlices = 16;
inline constexpr double kShortestStack = 20;   ///< mm
inline constexpr double kSteepestShear = 0.1;  ///< degrees between stack and slice normal
inline constexpr double kSteepestTilt = 45;    ///< degrees; gantries tilt at most 30
inline constexpr double kMostMissing = 0.05;   ///< share of interpolated slices
inline constexpr std::size_t kLargestGap = 3;  ///< multiple of the slice distance
inline constexpr double kMostVarying = 8;  ///< ratio of the largest to the smallest slice distance
inline constexpr double kJitterMm = 0.01;  ///< mm; maximum distance of a slice from its place,
/// A series that repeats positions has phases if it has nearly this many slices per position.
inline constexpr std::size_t kFewestRepeats = 2;
inline constexpr double kJitterShare = 0.02;  ///< or this share of the spacing if that is more

/// Judges the slices of one series (one SeriesInstanceUID), in any order, and plans their volume.
/// Order and spacing come only from positions along the normal of the slices. Refuses, with a
/// message, anything that is not a stack of original CT, MR or PT slices, and never returns a
/// volume whose shape could be wrong. Pure. Refuses volumes of more than `most_voxels`
/// ("over_quota"), and keeps only as many phases as fit.
Assessment classify(const std::vector<Slice>& slices, std::uint64_t most_voxels);

/// Returns "axial", "coronal", "sagittal" or "oblique" for a volume's direction.
std::string plane_name(const std::array<double, 9>& direction);

}  // namespace diaphane::dicom
