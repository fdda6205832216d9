#pragma once

#include <cstdint>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"

// Checks a browser's request for a file (docs/adr/0031) against its limits.

namespace diaphane::render {

inline constexpr std::size_t kMostFileMarks = 100;
inline constexpr double kLeastMarkUnit = 0.1, kMostMarkUnit = 100;
/// Maximum number of pixels of the picture of one label, and of all labels together.
inline constexpr std::uint64_t kMostLabelPixels = std::uint64_t{1} << 20;
inline constexpr std::uint64_t kMostPixelsOfLabels = std::uint64_t{1} << 24;

/// Appends a key view, whose index must be the next one. Index 0 starts a new list and always
/// clears `keys`. Otherwise `keys` is unchanged if it fails with kInvalid.
Result<void> note_key_view(std::vector<diaphane::v1::Scene>& keys,
                           const diaphane::v1::KeyView& view);

/// Appends a mark. `marks` is unchanged if it fails with kInvalid.
Result<void> note_file_mark(std::vector<diaphane::v1::FileMark>& marks,
                            const diaphane::v1::FileMark& mark);

Result<void> check_mark_unit(const diaphane::v1::FileRequest& request);

/// Checks the request of a large picture. Fails with kInvalid and the name of the wrong field.
Result<void> check_picture(const diaphane::v1::LargePicture& picture,
                           const std::vector<diaphane::v1::Scene>& keys);

}  // namespace diaphane::render
