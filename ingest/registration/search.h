#pragma once

#include <array>
#include <memory>
#include <vector>

#include "ingest/registration/register.h"

namespace diaphane::ingest {

using Point = std::array<double, 3>;
/// Three components of a versor and a shift in mm, about a centre.
using Pose = std::array<double, 6>;

/// Maximises the mutual information of two scans. Only search.cpp uses ITK, whose headers take long
/// to compile.
class InformationSearch {
 public:
  /// `centre` is the centre of rotation in the fixed scan. A rotation by an angle moves places by
  /// the angle times `radius`, in mm.
  InformationSearch(const CoarseScan& fixed, const CoarseScan& moving, Point centre, double radius);
  ~InformationSearch();
  InformationSearch(InformationSearch&&) noexcept;

  /// Chooses the places (mm) in the fixed scan at which values are compared.
  void set_places(const std::vector<Point>& places);
  /// Returns the mutual information at a pose, or a negative number if too few places lie in both
  /// scans.
  double information(const Pose& pose) const;
  /// Returns a pose nearby of the most information. The first step is `step` mm long.
  Pose climb(const Pose& start, double step) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns the map from points of the fixed scan to points of the moving scan, both in mm.
volume::Matrix matrix_of(const Pose& pose, const Point& centre);

}  // namespace diaphane::ingest
