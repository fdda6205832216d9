#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "api/handlers/message.h"
#include "api/service/data_set_store.h"
#include "api/service/placement.h"

/// The JSON forms of the schemas in api/openapi.yaml, one function each.
namespace diaphane::api {

nlohmann::ordered_json to_json(const DataSet& data_set);
nlohmann::ordered_json to_json(const SessionInfo& session);

/// Formats a time as RFC 3339 with milliseconds in UTC.
std::string rfc3339(Time time);
/// Formats a date as RFC 9110 requires (Upload-Expires).
std::string http_date(Time time);

Response json_response(int status, const nlohmann::ordered_json& body);
Response empty_response(int status);
/// Returns a JPEG below the cache directory, which the edge sends. Clients must revalidate it by
/// its ETag each time, because it may have been rendered again or may no longer be visible to
/// everyone.
Response cached_picture(const std::string& path);

}  // namespace diaphane::api
