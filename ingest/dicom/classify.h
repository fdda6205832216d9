#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/dicom/slice.h"
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
  std::array<std::uint32_t, 3> size{};  ///< columns, rows, slices
  std::array<double, 3> spacing{};      ///< mm
  std::array<double, 9> direction{};    ///< as volume::Header::direction
  volume::Modality modality = volume::Modality::kOther;
  double window_center = 0, window_width = 0;
};

/// Bounds of what is taken for a volume (design: ingest, "Cases and the right result").
inline constexpr std::size_t kFewestSlices = 16;
inline constexpr double kShortestStack = 20;   ///< mm
inline constexpr double kSteepestShear = 0.1;  ///< degrees between the stack and the slices' normal
inline constexpr double kJitterMm = 0.01;      ///< a slice's distance from its place: this,
inline constexpr double kJitterShare = 0.02;   ///< or this share of the spacing

/// Judges the slices of one series (all of one SeriesInstanceUID), in any order. Order and spacing
/// come from positions along the slices' normal alone. What is not a regular stack of original CT,
/// MR or PT slices is refused in words; never is a volume given whose shape could be wrong. Pure.
/// `most_voxels`: more is refused ("over_quota").
Assessment classify(const std::vector<Slice>& slices, std::uint64_t most_voxels);

/// "axial", "coronal", "sagittal" or "oblique", of a volume's direction.
std::string plane_name(const std::array<double, 9>& direction);

}  // namespace diaphane::dicom
