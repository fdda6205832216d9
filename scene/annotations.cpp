#include "scene/annotations.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/names.h"
#include "scene/check.h"

namespace diaphane::scene {
namespace {

constexpr int kMostMeasuredPoints = 3;

bool within(double value) { return std::fabs(value) <= kLongestDistance; }  // false for NaN

bool is_place(const v1::Vec3& place) {
  return within(place.x()) && within(place.y()) && within(place.z());
}

bool is_valid(const v1::Mark& mark) {
  return v1::Mark::Kind_IsValid(mark.kind()) && mark.kind() != v1::Mark::KIND_UNSPECIFIED &&
         mark.colour() < kMarkColours && is_place(mark.place()) && is_place(mark.tail()) &&
         is_place(mark.end()) && mark.radius() >= 0 && within(mark.radius());
}

}  // namespace

bool are_valid(const v1::Marks& marks) {
  std::set<std::uint32_t> ids;
  for (const v1::Mark& mark : marks.items()) {
    if (!is_valid(mark) || !ids.insert(mark.id()).second) return false;
  }
  return marks.items_size() <= kMostMarks;
}

bool are_valid(const v1::Measurements& measurements) {
  return measurements.items_size() <= kMostMeasurements &&
         std::ranges::all_of(measurements.items(), [](const v1::Measurements::Measurement& one) {
           return one.points_size() <= kMostMeasuredPoints &&
                  std::ranges::all_of(one.points(), is_place);
         });
}

v1::Marks cleaned(const v1::Marks& marks) {
  v1::Marks clean = marks;
  clean.DiscardUnknownFields();
  for (v1::Mark& mark : *clean.mutable_items()) {
    mark.set_text(clean_name(mark.text(), kLongestMarkText));
  }
  return clean;
}

Result<v1::Annotations> annotations_from_json(std::string_view json) {
  v1::Annotations annotations;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = false;
  const auto status = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), &annotations, options);
  // The parser's message is left out, because it would quote the texts.
  if (!status.ok()) return fail(ErrorCode::kInvalid, "must be a message Annotations");
  return check_annotations(std::move(annotations));
}

Result<v1::Annotations> check_annotations(v1::Annotations annotations) {
  if (!are_valid(annotations.marks())) {
    return fail(ErrorCode::kInvalid, "must have at most 50 marks with valid numbers");
  }
  if (!are_valid(annotations.measurements())) {
    return fail(ErrorCode::kInvalid, "must have at most 100 measurements with valid numbers");
  }
  *annotations.mutable_marks() = cleaned(annotations.marks());
  return annotations;
}

std::string annotations_to_json(const v1::Annotations& annotations) {
  std::string json;
  (void)google::protobuf::util::MessageToJsonString(annotations, &json);  // cannot fail
  return json;
}

}  // namespace diaphane::scene
