#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace diaphane::render {

/// Returns the codec name for a decoder (RFC 6381, "avc1.64001F") from the first sequence parameter
/// set of an Annex B stream: its profile, constraints and level (H.264, 7.3.2.1.1). Returns nullopt
/// if there is none.
std::optional<std::string> h264_decoder_name(std::string_view annex_b);

}  // namespace diaphane::render
