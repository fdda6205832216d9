#include "renderd/film/error_curve.h"

#include <cmath>

namespace diaphane::render {

void ErrorCurve::add(const ErrorPoint& point) {
  if (!std::isfinite(point.error)) return;
  if (!points_.empty() && point.samples <= points_.back().samples) return;
  const bool close_to_last_kept =
      points_.size() >= 2 && static_cast<double>(point.samples) <
                                 kStep * static_cast<double>(points_[points_.size() - 2].samples);
  if (close_to_last_kept) points_.pop_back();
  points_.push_back(point);
}

}  // namespace diaphane::render
