#pragma once

#include <string_view>

namespace diaphane::api {

/// The standard reason phrase of an HTTP status (RFC 9110, 6585, 4918; 460 is tus), or that of its
/// class where none is registered ("Client Error").
std::string_view reason_phrase(int status);

}  // namespace diaphane::api
