#pragma once

#include <string_view>

namespace diaphane {

/// Valid as RFC 3629 has it: no surrogates, nothing above U+10FFFF, nothing longer than needed. The
/// only text that Postgres and Protobuf take.
bool is_utf8(std::string_view text);

}  // namespace diaphane
