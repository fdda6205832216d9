#pragma once

#include <optional>
#include <vector>

#include "ingest/body/cells.h"

namespace diaphane::ingest {

/// The surface of a support on which a body lies, as depth over the position across and along the
/// patient. Supports are straight along the patient, so the visible part beside the body determines
/// the part below the body.
struct Surface {
  std::size_t across = 0, deep = 1;  ///< patient axes (0: x, 1: y)
  double sign = 1;                   ///< depth grows along +deep or -deep
  double low = 0, high = 0;          ///< mm, observed range of the position across
  double middle = 0, half = 1;       ///< mm, centre and half width of that range
  double along_middle = 0, along_half = 1;
  std::array<double, 7> terms{};

  /// Returns how far a place (mm along the patient's axes from the grid's corner) lies behind the
  /// surface; negative in front of it, and -infinity beside its range.
  double behind(const std::array<double, 3>& place) const;
  double depth(double u, double z) const;
};

/// Computes Surface::behind at the centres of cells from one evaluation per column of cells.
class CellsBehind {
 public:
  CellsBehind(const Surface& surface, const Cells& cells);
  double operator()(const std::array<int, 3>& place) const {
    const double depth = depths_[static_cast<std::size_t>(place[across_]) +
                                 width_ * static_cast<std::size_t>(place[2])];
    return step_ * (place[deep_] + 0.5) - depth;
  }

 private:
  std::size_t across_, deep_, width_;
  double step_;
  std::vector<double> depths_;  // infinity beside the surface
};

/// Fits the surface of a support that faces the body. `members` are the support's cells. Returns
/// nullopt if the surface is not smooth and straight.
std::optional<Surface> fit_surface(const volume::Volume& volume, const Cells& cells, int threshold,
                                   const CellList& members,
                                   const std::array<double, 3>& body_middle);

/// Returns the centre of a cell in mm from the grid's corner.
inline std::array<double, 3> middle_of(const Cells& cells, const std::array<int, 3>& place) {
  return {(place[0] + 0.5) * cells.mm[0], (place[1] + 0.5) * cells.mm[1],
          (place[2] + 0.5) * cells.mm[2]};
}

}  // namespace diaphane::ingest
