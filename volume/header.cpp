#include "volume/header.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>

#include "api/proto/volume.pb.h"
#include "common/try.h"
#include "volume/frame_of_reference.h"

namespace diaphane::volume {
namespace {

constexpr std::uint32_t kFormat = 1;

static_assert(static_cast<int>(PhaseKind::kIndex) == v1::VolumePhase::INDEX &&
              static_cast<int>(PhaseKind::kTime) == v1::VolumePhase::TIME &&
              static_cast<int>(PhaseKind::kCycle) == v1::VolumePhase::CYCLE &&
              static_cast<int>(PhaseKind::kEcho) == v1::VolumePhase::ECHO &&
              static_cast<int>(PhaseKind::kBValue) == v1::VolumePhase::B_VALUE);

double dot(const std::array<double, 9>& m, int a, int b) {
  return m[a] * m[b] + m[3 + a] * m[3 + b] + m[6 + a] * m[6 + b];
}

double determinant(const std::array<double, 9>& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

}  // namespace

const char* name_of(Modality modality) {
  switch (modality) {
    case Modality::kCt:
      return "CT";
    case Modality::kMr:
      return "MR";
    case Modality::kPt:
      return "PT";
    case Modality::kOther:
      break;
  }
  return "OTHER";
}

Result<void> check(const Header& header) {
  std::uint64_t count = 1;
  for (const std::uint32_t side : header.size) {
    if (side == 0 || side > kMaxSide)
      return fail(ErrorCode::kInvalid, "a dimension is zero or too large", "size");
    count *= side;  // three factors below 2^16 fit in 64 bits
  }
  if (count > kMaxVoxels) return fail(ErrorCode::kTooLarge, "more voxels than 2^32", "size");
  if (header.phases.size() == 1 || header.phases.size() > kMostPhases) {
    return fail(ErrorCode::kInvalid, "the number of phases must be from 2 to 1000, or 0", "phases");
  }
  if (header.total_voxel_count() > kMaxVoxels) {
    return fail(ErrorCode::kTooLarge, "all phases together have more voxels than 2^32", "phases");
  }
  if (!std::ranges::all_of(header.phases, [](const Phase& p) { return std::isfinite(p.value); })) {
    return fail(ErrorCode::kInvalid, "the value of a phase is not a number", "phases");
  }
  for (const double s : header.spacing) {
    if (!std::isfinite(s) || s <= 0)
      return fail(ErrorCode::kInvalid, "spacing must be positive", "spacing");
  }
  // Many writers store direction cosines as decimal text, so they are orthonormal only to about
  // four digits.
  constexpr double kTolerance = 1e-3;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      if (!(std::abs(dot(header.direction, a, b) - (a == b ? 1 : 0)) < kTolerance)) {
        return fail(ErrorCode::kInvalid, "the axes are not orthonormal", "direction");
      }
    }
  }
  if (!(determinant(header.direction) > 0)) {
    return fail(ErrorCode::kInvalid, "the axes are left-handed, so the image would be mirrored",
                "direction");
  }
  if (header.minimum > header.maximum || header.minimum < INT16_MIN || header.maximum > INT16_MAX) {
    return fail(ErrorCode::kInvalid, "the minimum and the maximum are inconsistent", "minimum");
  }
  if (!std::isfinite(header.window_center) || !std::isfinite(header.window_width) ||
      header.window_width < 0) {
    return fail(ErrorCode::kInvalid, "the window is not a number", "windowWidth");
  }
  if (header.origin && !std::all_of(header.origin->begin(), header.origin->end(),
                                    [](double v) { return std::isfinite(v); })) {
    return fail(ErrorCode::kInvalid, "the origin is not a place", "origin");
  }
  for (const double p : header.percentiles) {
    if (!std::isfinite(p))
      return fail(ErrorCode::kInvalid, "a percentile is not a number", "percentiles");
  }
  return {};
}

Result<std::string> to_json(const Header& header) {
  DIAPHANE_TRY(check(header));
  v1::VolumeHeader message;
  message.set_format(kFormat);
  for (const auto v : header.size) message.add_size(v);
  for (const auto v : header.spacing) message.add_spacing(v);
  for (const auto v : header.direction) message.add_direction(v);
  switch (header.modality) {
    case Modality::kCt:
      message.set_modality(v1::VolumeHeader::CT);
      break;
    case Modality::kMr:
      message.set_modality(v1::VolumeHeader::MR);
      break;
    case Modality::kPt:
      message.set_modality(v1::VolumeHeader::PT);
      break;
    case Modality::kOther:
      message.set_modality(v1::VolumeHeader::OTHER);
      break;
  }
  message.set_window_center(header.window_center);
  message.set_window_width(header.window_width);
  message.set_minimum(header.minimum);
  message.set_maximum(header.maximum);
  for (const auto v : header.percentiles) message.add_percentiles(v);
  message.set_content_hash(header.content_hash);
  for (const auto& repair : header.repairs) message.add_repairs(repair);
  if (header.origin) message.mutable_origin()->Assign(header.origin->begin(), header.origin->end());
  // The UID itself is on every image of the examination, and must not be stored.
  if (is_hidden_frame_of_reference(header.frame_of_reference)) {
    message.set_frame_of_reference(header.frame_of_reference);
  }
  message.set_label_hash(header.label_hash);
  for (const Phase& phase : header.phases) {
    v1::VolumePhase* stored = message.add_phases();
    stored->set_kind(static_cast<v1::VolumePhase::Kind>(phase.kind));
    stored->set_value(phase.value);
  }
  std::string text;
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;
  if (!google::protobuf::util::MessageToJsonString(message, &text, options).ok()) {
    return fail(ErrorCode::kInternal, "cannot serialise the header");
  }
  return text;
}

Result<Header> from_json(const std::string& text) {
  v1::VolumeHeader message;
  if (!google::protobuf::util::JsonStringToMessage(text, &message).ok()) {
    return fail(ErrorCode::kInvalid, "volume.json is not a volume header");
  }
  if (message.format() != kFormat) {
    return fail(ErrorCode::kUnsupported, "volume.json has an unsupported format version", "format");
  }
  if (message.size_size() != 3 || message.spacing_size() != 3 || message.direction_size() != 9 ||
      message.percentiles_size() != 8) {
    return fail(ErrorCode::kInvalid, "volume.json is missing sizes, spacings, axes or percentiles");
  }
  Header header;
  for (int i = 0; i < 3; ++i) {
    header.size[i] = message.size(i);
    header.spacing[i] = message.spacing(i);
  }
  for (int i = 0; i < 9; ++i) header.direction[i] = message.direction(i);
  for (int i = 0; i < 8; ++i) header.percentiles[i] = message.percentiles(i);
  switch (message.modality()) {
    case v1::VolumeHeader::CT:
      header.modality = Modality::kCt;
      break;
    case v1::VolumeHeader::MR:
      header.modality = Modality::kMr;
      break;
    case v1::VolumeHeader::PT:
      header.modality = Modality::kPt;
      break;
    default:
      header.modality = Modality::kOther;
      break;
  }
  header.window_center = message.window_center();
  header.window_width = message.window_width();
  header.minimum = message.minimum();
  header.maximum = message.maximum();
  header.content_hash = message.content_hash();
  header.repairs.assign(message.repairs().begin(), message.repairs().end());
  if (message.origin_size() == 3) {
    header.origin = {message.origin(0), message.origin(1), message.origin(2)};
  }
  header.frame_of_reference = message.frame_of_reference();
  header.label_hash = message.label_hash();
  for (const v1::VolumePhase& phase : message.phases()) {
    if (phase.kind() < v1::VolumePhase::Kind_MIN || phase.kind() > v1::VolumePhase::Kind_MAX) {
      return fail(ErrorCode::kInvalid, "a phase of volume.json has an unknown kind", "phases");
    }
    header.phases.push_back({static_cast<PhaseKind>(phase.kind()), phase.value()});
  }
  DIAPHANE_TRY(check(header));
  return header;
}

}  // namespace diaphane::volume
