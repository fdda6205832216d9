#include "api/routing/representations.h"

namespace diaphane::api {

std::string rfc3339(Time time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(
                      time - std::chrono::floor<std::chrono::seconds>(time))
                      .count();
  const std::string digits = std::to_string(1000 + ms);
  return utc_text(time, "%Y-%m-%dT%H:%M:%S") + "." + digits.substr(1) + "Z";
}

std::string http_date(Time time) { return utc_text(time, "%a, %d %b %Y %H:%M:%S GMT"); }

Response json_response(int status, const nlohmann::ordered_json& body) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = body.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return response;
}

Response empty_response(int status) {
  Response response;
  response.status = status;
  return response;
}

Response cached_picture(const std::string& path) {
  Response response;
  response.content_type = "image/jpeg";
  return std::move(response)
      .with("X-Accel-Redirect", "/_cache/" + path)
      .with("Cache-Control", "private, no-cache");
}

}  // namespace diaphane::api
