#pragma once

#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// The largest side of a volume, and the most voxels (8 GiB of int16).
inline constexpr std::uint32_t kMaxSide = 65535;
inline constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 32;

/// kInvalid, with what is wrong, unless the header describes a volume that can be shown: sizes
/// within the limits, spacing finite and positive, direction orthonormal with determinant +1,
/// minimum <= maximum.
Result<void> check(const Header& header);

/// The text of volume.json: Protobuf JSON of diaphane.v1.VolumeHeader (api/proto/volume.proto).
Result<std::string> to_json(const Header& header);
/// kInvalid for what is not such a text, has an unknown field, or does not pass check().
Result<Header> from_json(const std::string& text);

}  // namespace diaphane::volume
