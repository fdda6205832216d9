#include "ingest/dicom/stack.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "ingest/dicom/classify.h"

namespace diaphane::dicom {
namespace {

double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

Stack refused(Stack stack, const char* code, std::string text) {
  stack.code = code;
  stack.text = std::move(text);
  return stack;
}

/// Slices at places that others have already.
Stack repeated(Stack stack, std::size_t places) {
  const std::size_t n = stack.order.size();
  if (places == 1) {
    return refused(std::move(stack), "one_position",
                   "All slices lie at one position: this is a series in time, not a volume.");
  }
  if (n >= 2 * places - places / 10) {
    return refused(std::move(stack), "time_series",
                   "Several volumes lie at the same positions (phases, echoes or weightings); "
                   "a series in time is not shown.");
  }
  return refused(std::move(stack), "repeated_position",
                 "Some slices lie at the same position, and it is not known which of them counts.");
}

/// Uneven distances: slices that are missing, or another scheme altogether.
Stack uneven(Stack stack, const std::vector<double>& gaps) {
  std::vector<double> sorted = gaps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double usual = *middle;
  std::size_t missing = 0;
  for (const double gap : gaps) {
    const double steps = std::round(gap / usual);
    const double tolerance = std::max(kJitterMm, kJitterShare * usual) * std::max(steps, 1.0);
    if (steps < 1 || std::abs(gap - steps * usual) > 2 * tolerance) {
      return refused(
          std::move(stack), "varying_spacing",
          "The distance from slice to slice varies; such a series is not supported yet.");
    }
    missing += static_cast<std::size_t>(steps) - 1;
  }
  return refused(std::move(stack), "missing_slices",
                 counted(missing, "slice is missing", "slices are missing") +
                     " within the series; copy the disc again.");
}

}  // namespace

bool make_axes(const std::array<double, 6>& orientation, Axes& axes) {
  constexpr double kTolerance = 0.01;  // written with few digits by some scanners
  Vec3 row{orientation[0], orientation[1], orientation[2]};
  Vec3 column{orientation[3], orientation[4], orientation[5]};
  if (std::abs(length(row) - 1) > kTolerance || std::abs(length(column) - 1) > kTolerance ||
      std::abs(dot(row, column)) > kTolerance) {
    return false;
  }
  // Gram-Schmidt takes the rounding away.
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

  // The way from the first slice to the last, in the slices' plane and along their normal.
  const Vec3& first = positions[stack.order.front()];
  const Vec3 whole = minus(positions[stack.order.back()], first);
  const double height = dot(whole, axes.normal);
  const double shift_x = dot(whole, axes.row), shift_y = dot(whole, axes.column);
  const double shear = std::atan2(std::hypot(shift_x, shift_y), height) * 180 / std::numbers::pi;
  if (shear > kSteepestShear) {
    char degrees[32];
    std::snprintf(degrees, sizeof degrees, "%.1f", shear);
    return refused(std::move(stack), "tilted",
                   "The slices are tilted against their stack by " + std::string(degrees) +
                       " degrees (gantry tilt); such a series is not supported yet.");
  }
  stack.spacing = height / static_cast<double>(n - 1);
  const double tolerance = std::max(kJitterMm, kJitterShare * stack.spacing);
  double largest_gap_error = 0, largest_shift = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 here = minus(positions[stack.order[i]], first);
    const double share = dot(here, axes.normal) / height;
    stack.jitter = std::max(
        stack.jitter, std::abs(dot(here, axes.normal) - static_cast<double>(i) * stack.spacing));
    largest_shift = std::max(largest_shift, std::hypot(dot(here, axes.row) - share * shift_x,
                                                       dot(here, axes.column) - share * shift_y));
    if (i > 0)
      largest_gap_error = std::max(largest_gap_error, std::abs(gaps[i - 1] - stack.spacing));
  }
  // Positions are decimal text: a tenth of a pixel is more than rounding makes.
  if (largest_shift > std::max(kJitterMm, 0.1 * pixel)) {
    return refused(std::move(stack), "shifted_slices",
                   "Some slices are shifted sideways against the others.");
  }
  // Small steps in one direction add up: a slice must also be near its place.
  constexpr double kRounding = 1e-6;
  const bool even =
      stack.jitter <= tolerance + kRounding ||
      (largest_gap_error <= tolerance + kRounding && stack.jitter <= stack.spacing / 4);
  if (!even) return uneven(std::move(stack), gaps);
  stack.regular = true;
  return stack;
}

}  // namespace diaphane::dicom
