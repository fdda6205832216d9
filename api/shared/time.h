#pragma once

#include <chrono>
#include <string>

namespace diaphane::api {

using Time = std::chrono::system_clock::time_point;

/// Formats a time in UTC, in whole seconds, by the conversions of strftime().
std::string utc_text(Time time, const char* format);

}  // namespace diaphane::api
