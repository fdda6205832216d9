#include "api/handlers/representations.h"

#include <ctime>

namespace diaphane::api {
namespace {

std::string format(Time time, const char* form) {
  const std::time_t seconds =
      std::chrono::system_clock::to_time_t(std::chrono::floor<std::chrono::seconds>(time));
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[64];
  return std::string(text, std::strftime(text, sizeof text, form, &utc));
}

}  // namespace

std::string rfc3339(Time time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(
                      time - std::chrono::floor<std::chrono::seconds>(time))
                      .count();
  const std::string digits = std::to_string(1000 + ms);
  return format(time, "%Y-%m-%dT%H:%M:%S") + "." + digits.substr(1) + "Z";
}

std::string http_date(Time time) { return format(time, "%a, %d %b %Y %H:%M:%S GMT"); }

nlohmann::ordered_json to_json(const DataSet& d) {
  nlohmann::ordered_json json;
  json["id"] = d.id;
  json["title"] = d.title;
  json["state"] = to_string(d.state);
  json["description"] = d.description;
  json["body_part"] = nullptr;
  if (!d.body_part.empty()) json["body_part"] = d.body_part;
  json["role"] = to_string(d.role);
  json["owner_name"] = d.owner_name;
  json["owned"] = d.owned();
  json["is_public"] = d.is_public;
  json["is_sample"] = d.is_sample;
  json["public_slices"] = d.slices_for_everybody();
  json["refusal"] = nullptr;
  if (d.state == DataSetState::kRefused) {
    json["refusal"] = {{"code", d.refusal_code}, {"text", d.refusal_text}};
  }
  json["waiting_for"] = nullptr;
  if (!d.waiting_for.empty()) json["waiting_for"] = d.waiting_for;
  json["volume"] = nullptr;
  if (d.state == DataSetState::kReady) {
    json["volume"] = {{"modality", d.modality},
                      {"size", d.size},
                      {"spacing_mm", d.spacing},
                      {"bytes", d.volume_bytes},
                      {"repairs", d.repairs}};
  }
  json["upload"] = nullptr;
  if (d.upload) {
    json["upload"] = {{"url", "/v1/uploads/" + d.upload->id},
                      {"bytes", d.upload->length},
                      {"received_bytes", d.upload->received},
                      {"expires_at", rfc3339(d.upload->expires_at)}};
  }
  json["shared"] = nullptr;
  if (d.owned()) json["shared"] = {{"people", d.people}, {"links", d.links}};
  json["taken_down"] = nullptr;
  if (d.taken_down) json["taken_down"] = {{"reason", d.taken_down_reason}};
  json["published_at"] = nullptr;
  if (d.published_at) json["published_at"] = rfc3339(*d.published_at);
  json["anonymised_at"] = nullptr;
  if (d.anonymised_at) json["anonymised_at"] = rfc3339(*d.anonymised_at);
  json["created_at"] = rfc3339(d.created_at);
  json["updated_at"] = rfc3339(d.updated_at);
  return json;
}

nlohmann::ordered_json to_json(const SessionInfo& session) {
  return {{"session_id", session.id}, {"data_set_id", session.data_set_id}};
}

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
