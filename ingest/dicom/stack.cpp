#include "ingest/dicom/stack.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "ingest/dicom/classify.h"

namespace diaphane::dicom {
namespace {

constexpr double kRounding = 1e-6;  // mm

double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

Stack refused(Stack stack, const char* code, std::string text) {
  stack.code = code;
  stack.text = std::move(text);
  return stack;
}

/// Refuses a stack in which slices share positions.
Stack repeated(Stack stack, std::size_t places) {
  if (places == 1) {
    return refused(std::move(stack), "one_position",
                   "All slices are at the same position. This is a time series, not a 3D scan.");
  }
  return refused(std::move(stack), "repeated_position",
                 "Some slices are at the same position, and it is unclear which of them to use.");
}

double tolerance_of(double spacing) { return std::max(kJitterMm, kJitterShare * spacing); }

bool alike(double a, double b) {
  return std::abs(a - b) <= 2 * tolerance_of(std::min(a, b)) + kRounding;
}

/// Returns the distances that several successive slices have in common, in ascending order. The
/// scanner was set to these, while a hole in an even series occurs once.
std::vector<double> main_gaps(const std::vector<double>& gaps) {
  constexpr std::size_t kSuccession = 3;
  std::vector<double> found;
  for (std::size_t from = 0; from < gaps.size();) {
    std::size_t to = from + 1;
    while (to < gaps.size() && alike(gaps[from], gaps[to])) ++to;
    const double mean = std::accumulate(gaps.begin() + static_cast<std::ptrdiff_t>(from),
                                        gaps.begin() + static_cast<std::ptrdiff_t>(to), 0.0) /
                        static_cast<double>(to - from);
    const bool known =
        std::any_of(found.begin(), found.end(), [&](double gap) { return alike(gap, mean); });
    if (to - from >= kSuccession && !known) found.push_back(mean);
    from = to;
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Returns the number of steps of `usual` in each gap, or an empty vector if a gap is not a
/// multiple of it.
std::vector<std::size_t> whole_steps(const std::vector<double>& gaps, double usual) {
  std::vector<std::size_t> steps;
  for (const double gap : gaps) {
    const double n = std::round(gap / usual);
    if (n < 1 || std::abs(gap - n * usual) > 2 * tolerance_of(usual) * n) return {};
    steps.push_back(static_cast<std::size_t>(n));
  }
  return steps;
}

/// Returns whether holes are the only irregularity, so that each slice is near its place once they
/// are filled.
bool has_holes(const std::vector<std::size_t>& steps, const std::vector<double>& gaps,
               double height) {
  const std::size_t all = std::accumulate(steps.begin(), steps.end(), std::size_t{0});
  if (all == steps.size() || steps.empty()) return false;
  const double spacing = height / static_cast<double>(all);
  double at = 0, place = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    at += gaps[i];
    place += static_cast<double>(steps[i]) * spacing;
    if (std::abs(at - place) > spacing / 4) return false;
  }
  return true;
}

/// Case 5: fills the holes of an even stack if they are few and small, or refuses the stack.
Stack with_holes(Stack stack, const std::vector<std::size_t>& steps, double height) {
  std::size_t all = 1, largest = 1;
  for (const std::size_t n : steps) {
    all += n;
    largest = std::max(largest, n);
  }
  const std::size_t missing = all - stack.order.size();
  if (static_cast<double>(missing) > kMostMissing * static_cast<double>(all) ||
      largest > kLargestGap) {
    return refused(std::move(stack), "missing_slices",
                   counted(missing, "slice is missing", "slices are missing") +
                       " within the series. Try copying the files from the disc again.");
  }
  stack.missing = missing;
  stack.spacing = height / static_cast<double>(all - 1);
  stack.sources = {Source{}};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (std::size_t k = 1; k <= steps[i]; ++k) {
      stack.sources.push_back(
          {static_cast<double>(i) + static_cast<double>(k) / static_cast<double>(steps[i]), {}});
    }
  }
  stack.is_volume = true;
  return stack;
}

/// Case 6: resamples the stack at the smallest of its main distances.
Stack with_varying(Stack stack, const std::vector<double>& gaps, const std::vector<double>& mains,
                   double height) {
  const auto [least, most] = std::minmax_element(gaps.begin(), gaps.end());
  if (*most > kMostVarying * *least) {
    return refused(std::move(stack), "varying_spacing",
                   "The slice spacing varies too much for a 3D image.");
  }
  stack.varying = {*least, *most};
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  const double target = mains.empty() ? sorted[sorted.size() / 10] : mains.front();
  // Both ends are kept, so the steps are slightly finer than requested.
  const double steps = std::ceil(height / target - 0.01);
  stack.spacing = height / steps;
  std::size_t i = 0;
  double below = 0;  // mm, height of slice i
  for (std::size_t k = 0; k <= static_cast<std::size_t>(steps); ++k) {
    const double at = std::min(static_cast<double>(k) * stack.spacing, height);
    while (i + 1 < gaps.size() && below + gaps[i] <= at) below += gaps[i++];
    double slice = static_cast<double>(i) + std::min((at - below) / gaps[i], 1.0);
    // A slice that lies in its place is used unchanged.
    const double off = std::abs(slice - std::round(slice)) * gaps[i];
    if (off < tolerance_of(stack.spacing)) slice = std::round(slice);
    stack.sources.push_back({slice, {}});
  }
  stack.is_volume = true;
  return stack;
}

/// Handles uneven distances, which come from another acquisition scheme, missing slices or a lack
/// of order.
Stack uneven(Stack stack, const std::vector<double>& gaps, double height) {
  const std::vector<double> mains = main_gaps(gaps);
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  if (mains.size() < 2) {
    const double usual = mains.empty() ? sorted[sorted.size() / 2] : mains.front();
    const std::vector<std::size_t> steps = whole_steps(gaps, usual);
    if (has_holes(steps, gaps, height)) return with_holes(std::move(stack), steps, height);
  }
  return with_varying(std::move(stack), gaps, mains, height);
}

/// Case 4: shifts each slice of the volume according to its place in the tilted stack.
void straighten(Stack& stack, double degrees, double height, double x, double y) {
  stack.tilt = degrees;
  if (stack.sources.empty()) {
    for (std::size_t i = 0; i < stack.order.size(); ++i) {
      stack.sources.push_back({static_cast<double>(i), {}});
    }
  }
  for (std::size_t k = 0; k < stack.sources.size(); ++k) {
    const double share = static_cast<double>(k) * stack.spacing / height;
    stack.sources[k].shift = {share * x, share * y};
  }
}

}  // namespace

bool make_axes(const std::array<double, 6>& orientation, Axes& axes) {
  constexpr double kTolerance = 0.01;  // some scanners write few digits
  Vec3 row{orientation[0], orientation[1], orientation[2]};
  Vec3 column{orientation[3], orientation[4], orientation[5]};
  if (std::abs(length(row) - 1) > kTolerance || std::abs(length(column) - 1) > kTolerance ||
      std::abs(dot(row, column)) > kTolerance) {
    return false;
  }
  // Gram-Schmidt removes rounding errors.
  const double row_length = length(row);
  for (double& v : row) v /= row_length;
  const double along = dot(row, column);
  for (std::size_t i = 0; i < 3; ++i) column[i] -= along * row[i];
  const double column_length = length(column);
  for (double& v : column) v /= column_length;
  axes = {row, column, cross(row, column)};
  return true;
}

Stack arrange(const std::vector<Vec3>& positions, const Axes& axes, double pixel) {
  Stack stack;
  const std::size_t n = positions.size();
  const auto along = [&](std::size_t i) { return dot(positions[i], axes.normal); };
  stack.order.resize(n);
  std::iota(stack.order.begin(), stack.order.end(), std::size_t{0});
  std::sort(stack.order.begin(), stack.order.end(),
            [&](std::size_t a, std::size_t b) { return along(a) < along(b); });

  std::vector<double> gaps;
  std::size_t places = 1;
  for (std::size_t i = 1; i < n; ++i) {
    gaps.push_back(along(stack.order[i]) - along(stack.order[i - 1]));
    if (gaps.back() > kJitterMm) ++places;
  }
  if (places < n) return repeated(std::move(stack), places);

  // The vector from the first slice to the last, within the plane of the slices and along their
  // normal.
  const Vec3& first = positions[stack.order.front()];
  const Vec3 extent = minus(positions[stack.order.back()], first);
  const double height = dot(extent, axes.normal);
  const double shift_x = dot(extent, axes.row), shift_y = dot(extent, axes.column);
  const double shear = std::atan2(std::hypot(shift_x, shift_y), height) * 180 / std::numbers::pi;
  if (shear > kSteepestTilt) {
    return refused(std::move(stack), "tilted",
                   "The slices are shifted too far relative to each other for a 3D image.");
  }
  stack.spacing = height / static_cast<double>(n - 1);
  const double tolerance = tolerance_of(stack.spacing);
  double largest_gap_error = 0, largest_shift = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 offset = minus(positions[stack.order[i]], first);
    const double share = dot(offset, axes.normal) / height;
    stack.jitter = std::max(
        stack.jitter, std::abs(dot(offset, axes.normal) - static_cast<double>(i) * stack.spacing));
    largest_shift = std::max(largest_shift, std::hypot(dot(offset, axes.row) - share * shift_x,
                                                       dot(offset, axes.column) - share * shift_y));
    if (i > 0)
      largest_gap_error = std::max(largest_gap_error, std::abs(gaps[i - 1] - stack.spacing));
  }
  // Positions are rounded decimal text, but rounding moves them by less than a tenth of a pixel.
  if (largest_shift > std::max(kJitterMm, 0.1 * pixel)) {
    return refused(std::move(stack), "shifted_slices", "Some slices are shifted sideways.");
  }
  // Small steps in one direction add up, so a slice must also be near its place.
  const bool even =
      stack.jitter <= tolerance + kRounding ||
      (largest_gap_error <= tolerance + kRounding && stack.jitter <= stack.spacing / 4);
  stack.is_volume = even;
  if (!even) {
    stack.jitter = 0;
    stack = uneven(std::move(stack), gaps, height);
  }
  if (stack.is_volume && shear > kSteepestShear) straighten(stack, shear, height, shift_x, shift_y);
  return stack;
}

}  // namespace diaphane::dicom
