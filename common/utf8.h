#pragma once

#include <string_view>

namespace diaphane {

/// Returns whether a text is valid UTF-8 (RFC 3629): no surrogates, nothing above U+10FFFF and no
/// overlong encodings. Postgres and Protobuf accept no other text.
bool is_utf8(std::string_view text);

}  // namespace diaphane
