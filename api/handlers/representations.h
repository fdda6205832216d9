#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "api/handlers/message.h"
#include "api/service/data_set_store.h"
#include "api/service/placement.h"

/// The schemas of api/openapi.yaml, one function each.
namespace diaphane::api {

nlohmann::ordered_json to_json(const DataSet& data_set);
nlohmann::ordered_json to_json(const SessionInfo& session);

/// RFC 3339 with milliseconds, UTC.
std::string rfc3339(Time time);
/// The date of RFC 9110 (Upload-Expires).
std::string http_date(Time time);

Response json_response(int status, const nlohmann::ordered_json& body);
Response empty_response(int status);
/// A JPEG below the cache directory, which the edge sends. Asked for each time, by its ETag: it may
/// have been made anew, or be no longer for everybody.
Response cached_picture(const std::string& path);

}  // namespace diaphane::api
