#include "volume/curve.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace diaphane::volume {
namespace {

constexpr double kFarthestPoint = 1e6;  // mm
constexpr double kSamePoint = 1e-3;     // mm
/// Chords per segment. They are shorter than the curve by a part of (step / radius)^2 / 24.
constexpr std::size_t kSteps = 64;

Vector sum(const Vector& a, const Vector& b, double factor = 1) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
Vector difference(const Vector& a, const Vector& b) { return sum(a, b, -1); }
Vector scaled(const Vector& a, double factor) { return sum({}, a, factor); }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length_of(const Vector& a) { return std::sqrt(dot(a, a)); }
Vector unit(const Vector& a) { return scaled(a, 1 / length_of(a)); }
/// Returns the unit vector that is perpendicular to the unit vector `along` and nearest to `a`.
Vector perpendicular(const Vector& a, const Vector& along) {
  return unit(sum(a, along, -dot(a, along)));
}
Vector reflected(const Vector& a, const Vector& normal) {
  return sum(a, normal, -2 * dot(normal, a) / dot(normal, normal));
}

Result<std::vector<Vector>> distinct(std::span<const Vector> points) {
  const auto refuse = [](const char* why) { return fail(ErrorCode::kInvalid, why, "points"); };
  if (points.size() > kMostCurvePoints) return refuse("This curve has too many points.");
  std::vector<Vector> kept;
  for (const Vector& point : points) {
    const bool near = std::ranges::all_of(
        point, [](double entry) { return std::abs(entry) <= kFarthestPoint; });  // false for NaN
    if (!near) return refuse("A point of this curve is not valid.");
    if (kept.empty() || length_of(difference(point, kept.back())) >= kSamePoint) {
      kept.push_back(point);
    }
  }
  if (kept.size() < 2) return refuse("A curve needs two different points.");
  return kept;
}

}  // namespace

Result<Curve> Curve::through(std::span<const Vector> points) {
  auto kept = distinct(points);
  if (!kept) return tl::unexpected(kept.error());
  // Mirrored points before the first and after the last one let the curve end straight.
  std::vector<Vector> knots{difference(scaled((*kept)[0], 2), (*kept)[1])};
  knots.insert(knots.end(), kept->begin(), kept->end());
  knots.push_back(difference(scaled(kept->back(), 2), kept->at(kept->size() - 2)));
  Curve curve;
  for (std::size_t i = 1; i + 2 < knots.size(); ++i) {
    const auto chord = [&](std::size_t k) { return difference(knots[k + 1], knots[k]); };
    const auto interval = [&](std::size_t k) { return std::sqrt(length_of(chord(k))); };
    // The derivative at the point between two chords, per interval of its segment.
    const auto derivative = [&](std::size_t k) {
      const double before = interval(k - 1), after = interval(k);
      const Vector one = scaled(chord(k - 1), 1 / before), two = scaled(chord(k), 1 / after);
      const Vector both = scaled(sum(chord(k - 1), chord(k)), 1 / (before + after));
      return scaled(difference(sum(one, two), both), interval(i));
    };
    curve.segments_.push_back({knots[i], knots[i + 1], derivative(i), derivative(i + 1)});
  }
  for (std::size_t k = 0; k <= kSteps * curve.segments_.size(); ++k) {
    Node node;
    node.parameter = static_cast<double>(k) / kSteps;
    node.frame.place = curve.place_at(node.parameter);
    if (k > 0) {
      const Node& before = curve.nodes_.back();
      node.arc = before.arc + length_of(difference(node.frame.place, before.frame.place));
    }
    curve.nodes_.push_back(node);
  }
  curve.find_tangents();
  curve.turn_frames();
  return curve;
}

Vector Curve::place_at(double parameter) const {
  const std::size_t i = std::min(static_cast<std::size_t>(parameter), segments_.size() - 1);
  const Segment& segment = segments_[i];
  const double u = parameter - static_cast<double>(i);
  const double v = 1 - u;
  const Vector ends =
      sum(scaled(segment.from, v * v * (1 + 2 * u)), segment.to, u * u * (3 - 2 * u));
  return sum(sum(ends, segment.leaving, u * v * v), segment.arriving, -u * u * v);
}

Vector Curve::derivative_at(double parameter) const {
  const std::size_t i = std::min(static_cast<std::size_t>(parameter), segments_.size() - 1);
  const Segment& segment = segments_[i];
  const double u = parameter - static_cast<double>(i);
  const double v = 1 - u;
  const Vector ends = scaled(difference(segment.to, segment.from), 6 * u * v);
  return sum(sum(ends, segment.leaving, v * (1 - 3 * u)), segment.arriving, u * (3 * u - 2));
}

void Curve::find_tangents() {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const Vector derivative = derivative_at(nodes_[k].parameter);
    // Where the curve turns back on itself, the derivative vanishes, and the next chord decides.
    const std::size_t next = std::min(k + 1, nodes_.size() - 1);
    const Vector chord = difference(nodes_[next].frame.place, nodes_[next - 1].frame.place);
    const bool moves = length_of(derivative) > 1e-6 * length_of(chord);
    nodes_[k].frame.along = unit(moves ? derivative : chord);
  }
}

Vector Curve::first_across() const {
  constexpr std::array<Vector, 3> kDirections{{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}};
  constexpr double kNearlyParallel = 0.95;
  const Vector& along = nodes_.front().frame.along;
  const Vector* best = nullptr;
  double least = 0;
  for (const Vector& direction : kDirections) {
    if (std::abs(dot(along, direction)) > kNearlyParallel) continue;
    double parallel = 0;
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      const Vector chord = difference(nodes_[k].frame.place, nodes_[k - 1].frame.place);
      const double part = dot(chord, direction);
      parallel += part * part / (nodes_[k].arc - nodes_[k - 1].arc);
    }
    // A margin, so that rounding does not decide between equally parallel ones.
    if (best && !(parallel < least - 1e-9 * length())) continue;
    best = &direction;
    least = parallel;
  }
  return perpendicular(*best, along);
}

void Curve::turn_frames() {
  nodes_.front().frame.across = first_across();
  for (std::size_t k = 1; k < nodes_.size(); ++k) {
    const Frame& before = nodes_[k - 1].frame;
    Frame& frame = nodes_[k].frame;
    const Vector chord = difference(frame.place, before.place);
    const Vector along = reflected(before.along, chord);
    Vector across = reflected(before.across, chord);
    const Vector second = difference(frame.along, along);
    // Where the curve turns back on itself, the first reflection is enough.
    if (dot(second, second) > 1e-12) across = reflected(across, second);
    frame.across = perpendicular(across, frame.along);
  }
}

Curve::Frame Curve::at(double arc) const {
  const double held = std::clamp(arc, 0.0, length());
  const auto after = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, held,
                                      [](double at, const Node& node) { return at < node.arc; });
  const Node &low = *(after - 1), &high = *after;
  const double part = (held - low.arc) / (high.arc - low.arc);
  const auto between = [&](const Vector& a, const Vector& b) {
    return sum(scaled(a, 1 - part), b, part);
  };
  // At a point where the curve turns back on itself, the tangents at both ends are opposite.
  const bool turns_back = dot(low.frame.along, high.frame.along) < 0;
  Frame frame;
  frame.place = place_at(low.parameter + part * (high.parameter - low.parameter));
  frame.along = turns_back ? low.frame.along : unit(between(low.frame.along, high.frame.along));
  frame.across = turns_back
                     ? low.frame.across
                     : perpendicular(between(low.frame.across, high.frame.across), frame.along);
  return frame;
}

}  // namespace diaphane::volume
