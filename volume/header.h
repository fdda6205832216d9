#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// Largest number of voxels along an axis, and in total (8 GiB of int16).
inline constexpr std::uint32_t kMaxSide = 65535;
inline constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 32;

/// Checks that the header describes a volume that can be shown: sizes within the limits, finite and
/// positive spacing, orthonormal direction with determinant +1, and minimum <= maximum. Returns
/// kInvalid, or kTooLarge for too many voxels, with the reason.
Result<void> check(const Header& header);

/// Returns "CT", "MR", "PT" or "OTHER", as the REST API, the database and the command line name it.
const char* name_of(Modality modality);

/// Returns the text of volume.json: Protobuf JSON of diaphane.v1.VolumeHeader
/// (api/proto/volume.proto). Returns the errors of check().
Result<std::string> to_json(const Header& header);
/// Parses the text of volume.json. Returns kInvalid if it is malformed or has an unknown field,
/// kUnsupported for another format version, or the errors of check().
Result<Header> from_json(const std::string& text);

}  // namespace diaphane::volume
