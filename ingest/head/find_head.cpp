#include "ingest/head/find_head.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "ingest/head/signs.h"

namespace diaphane::ingest {
namespace {

// Parameters of the plane that removes the face: how far its normal points down from straight
// ahead, and how far in front of the brain it passes. Chosen on the heads of docs/privacy.md.
constexpr double kDownDegrees = 50;
constexpr double kBeforeBrainMm = 8;
// No margin, because the ellipsoid of head_shape.cpp extends further forward than a brain.
constexpr double kBeforeShapeMm = 0;
// How far the longest axis of a brain points up from straight ahead in a head that is held upright:
// the median of four brains without a skull (docs/privacy.md).
constexpr double kLongAxisUpDegrees = 10;
constexpr double kMostTurnedDegrees = 75;  // beyond this, the axis does not fit the stated position

using volume::Vector;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

Vector unit(const Vector& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

Vector sum(double a, const Vector& u, double b, const Vector& v) {
  return {a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]};
}

double dot(const Vector& u, const Vector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

/// Rotates `v` towards the feet within the vertical plane that contains it.
Vector lowered(const Vector& v, double degrees) {
  const Vector feet{0, 0, -1};
  const Vector down = unit(sum(1, feet, -dot(feet, v), v));
  return sum(std::cos(radians(degrees)), v, std::sin(radians(degrees)), down);
}

Vector middle_of(const Brain& brain) {
  Vector middle{};
  for (const auto& place : brain) {
    middle = sum(1, middle, 1 / static_cast<double>(brain.size()), place);
  }
  return middle;
}

/// Estimates where the head looks from the longest axis of its brain, which is the main axis of the
/// covariance, by power iteration from straight ahead.
Vector gaze_of(const Brain& brain) {
  const Vector ahead{0, -1, 0};
  const Vector middle = middle_of(brain);
  Vector axis = ahead;
  for (int step = 0; step < 60; ++step) {
    Vector next{};
    for (const auto& place : brain) {
      const Vector from = sum(1, place, -1, middle);
      next = sum(1, next, dot(from, axis), from);
    }
    if (dot(next, next) == 0) return ahead;
    axis = unit(next);
  }
  const bool likely = dot(axis, ahead) > std::cos(radians(kMostTurnedDegrees));
  return likely ? lowered(axis, kLongAxisUpDegrees) : ahead;
}

volume::Region face_cut(const Brain& brain, const Vector& gaze, double before_mm,
                        const volume::Header& header) {
  const Vector normal = lowered(gaze, kDownDegrees);
  const Vector middle = middle_of(brain);
  double most = -1e9;
  for (const auto& place : brain) most = std::max(most, dot(normal, sum(1, place, -1, middle)));
  const WorldBox box = world_box(header);
  volume::Region region{box.low, box.high, {}};
  region.planes.push_back({sum(1, middle, most + before_mm, normal), normal});
  return region;
}

}  // namespace

HeadFinding find_head(const volume::Volume& volume) {
  const Coarse coarse = coarse_of(volume);
  const bool ct = volume.header.modality == volume::Modality::kCt;
  const auto brain = ct ? find_brain_case(coarse) : find_head_shape(coarse);
  HeadFinding finding;
  finding.sign = "none";
  if (!brain) return finding;
  finding.found = true;
  finding.sign = ct ? "brain_case" : "head_shape";
  // The brain of an MR is an estimate that always looks straight ahead.
  volume::Region region = ct ? face_cut(*brain, gaze_of(*brain), kBeforeBrainMm, volume.header)
                             : face_cut(*brain, {0, -1, 0}, kBeforeShapeMm, volume.header);
  // A cut that removes nothing is not proposed.
  const auto cut = volume::plan_cut(volume.header, region);
  if (cut && cut->kept < volume.header.voxel_count()) finding.proposal = std::move(region);
  return finding;
}

std::string to_json(const HeadFinding& finding) {
  nlohmann::json json{{"found", finding.found}, {"sign", finding.sign}, {"proposal", nullptr}};
  if (finding.proposal) {
    json["proposal"] = nlohmann::json::parse(volume::to_json(*finding.proposal));
  }
  return json.dump();
}

}  // namespace diaphane::ingest
