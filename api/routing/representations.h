#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "api/routing/message.h"
#include "api/shared/time.h"

/// The parts of responses that the routes of all features have in common.
namespace diaphane::api {

/// Formats a time as RFC 3339 with milliseconds in UTC.
std::string rfc3339(Time time);
/// Formats a date as RFC 9110 requires (Upload-Expires).
std::string http_date(Time time);

Response json_response(int status, const nlohmann::ordered_json& body);
Response empty_response(int status);
/// Returns a JPEG below the cache directory, which the edge sends. Clients must revalidate it by
/// its ETag each time, because it may have been rendered again, or the client may have lost access
/// to it.
Response cached_picture(const std::string& path);

}  // namespace diaphane::api
