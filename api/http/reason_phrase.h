#pragma once

#include <string_view>

namespace diaphane::api {

/// Returns the standard reason phrase of an HTTP status (RFC 9110, 6585, 4918; 460 is from tus), or
/// that of its class if none is registered ("Client Error").
std::string_view reason_phrase(int status);

}  // namespace diaphane::api
