#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ingest/dicom/slice.h"
#include "ingest/dicom/stack.h"
#include "volume/volume.h"

namespace diaphane::dicom {

/// How the slices of a series that share positions form several volumes of one region.
struct PhasePlan {
  std::string code, text;  ///< why they do not; empty if they do
  std::vector<volume::Phase> phases;
  /// The slices of each phase, as indices into all slices, by rising distance along the normal.
  std::vector<std::vector<std::size_t>> slices;
  std::size_t incomplete = 0;  ///< phases that were left out because slices of them are missing
  std::size_t uncommon = 0;    ///< slices at the ends that were left out, not all phases have them
};

/// Smallest share of the positions that all phases must have in common. Phases are left out until
/// they do.
inline constexpr double kLeastCommon = 0.9;
/// Smallest share of the phases that must be complete.
inline constexpr double kLeastComplete = 0.5;

/// Returns the slices `kept` in groups of the same position, by rising distance along the normal.
std::vector<std::vector<std::size_t>> places_of(const std::vector<Slice>& slices,
                                                const std::vector<std::size_t>& kept,
                                                const Axes& axes);

/// Splits slices into phases by the first attribute of Distinction that distinguishes slices at the
/// same position. If each position has equally many slices, the n-th slice of each belongs to the
/// n-th phase, because trigger times may differ slightly between positions. Otherwise, slices with
/// the same value belong together. Pure. Precondition: at least one place has several slices, and
/// all slices have positions. `pixel` is the smaller pixel spacing in mm.
PhasePlan split_phases(const std::vector<Slice>& slices,
                       const std::vector<std::vector<std::size_t>>& places, double pixel);

}  // namespace diaphane::dicom
