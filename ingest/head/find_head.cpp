#include "ingest/head/find_head.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "ingest/head/signs.h"

namespace diaphane::ingest {
namespace {

// Of the plane that takes the face: how far its normal points down from straight ahead, and how far
// in front of the brain it passes. Chosen on the heads of docs/privacy.md.
constexpr double kDownDegrees = 50;
constexpr double kBeforeBrainMm = 12;
constexpr double kBeforeShapeMm = 0;  // an ellipsoid is fuller than a brain where the face begins

volume::Region face_cut(const Brain& brain, double before_mm, const volume::Header& header) {
  const double down = kDownDegrees * std::numbers::pi / 180;
  const volume::Vector normal{0, -std::cos(down), -std::sin(down)};
  double most = -1e9;
  volume::Vector middle{};
  for (const auto& place : brain) {
    most = std::max(most, normal[1] * place[1] + normal[2] * place[2]);
    for (std::size_t i = 0; i < 3; ++i) middle[i] += place[i] / static_cast<double>(brain.size());
  }
  const double ahead = most + before_mm - (normal[1] * middle[1] + normal[2] * middle[2]);
  const WorldBox box = world_box(header);
  volume::Region region{box.low, box.high, {}};
  region.planes.push_back(
      {{middle[0], middle[1] + ahead * normal[1], middle[2] + ahead * normal[2]}, normal});
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
  volume::Region region = face_cut(*brain, ct ? kBeforeBrainMm : kBeforeShapeMm, volume.header);
  // A cut that would take nothing is none to propose.
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
