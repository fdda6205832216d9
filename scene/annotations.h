#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "api/proto/stream.pb.h"
#include "common/result.h"

/// Marks and measurements of a scan, which the stream shares and the API stores.
namespace diaphane::scene {

inline constexpr int kMostMarks = 50;
inline constexpr std::size_t kLongestMarkText = 80;  ///< characters
inline constexpr std::uint32_t kMarkColours = 8;
inline constexpr int kMostMeasurements = 100;

/// Returns whether all numbers are finite and within their limits.
bool are_valid(const diaphane::v1::Marks& marks);
bool are_valid(const diaphane::v1::Measurements& measurements);

/// Returns a copy without unknown fields, whose texts are cleaned like names (common/names.h).
diaphane::v1::Marks cleaned(const diaphane::v1::Marks& marks);

/// Checks and cleans annotations. Returns kInvalid for invalid numbers or kinds.
Result<diaphane::v1::Annotations> check_annotations(diaphane::v1::Annotations annotations);

/// Parses Protobuf JSON without unknown fields, checks and cleans it. Returns kInvalid on failure.
Result<diaphane::v1::Annotations> annotations_from_json(std::string_view json);
std::string annotations_to_json(const diaphane::v1::Annotations& annotations);

}  // namespace diaphane::scene
