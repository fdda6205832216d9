#include "api/scans/data_set_format.h"

#include "api/routing/representations.h"

namespace diaphane::api {

namespace {

nlohmann::ordered_json to_json(const Upload& upload) {
  return {{"url", "/v1/uploads/" + upload.id},
          {"bytes", upload.length},
          {"received_bytes", upload.received},
          {"expires_at", rfc3339(upload.expires_at)}};
}

nlohmann::ordered_json to_json(const LabelState& labels) {
  nlohmann::ordered_json json{{"count", labels.count},
                              {"bytes", labels.bytes},
                              {"placing", labels.placing},
                              {"upload", nullptr},
                              {"refusal", nullptr}};
  if (labels.upload) json["upload"] = to_json(*labels.upload);
  if (!labels.refusal_code.empty()) {
    json["refusal"] = {{"code", labels.refusal_code}, {"text", labels.refusal_text}};
  }
  return json;
}

}  // namespace

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
  json["public_slices"] = d.allowed_to_public().slices;
  json["public_downloads"] = d.allowed_to_public().downloads;
  json["refusal"] = nullptr;
  if (d.state == DataSetState::kRefused) {
    json["refusal"] = {{"code", d.refusal_code}, {"text", d.refusal_text}};
  }
  json["waiting_for"] = nullptr;
  if (!d.waiting_for.empty()) json["waiting_for"] = d.waiting_for;
  json["volume"] = nullptr;
  if (d.state == DataSetState::kReady) {
    json["volume"] = {{"modality", d.modality},  {"size", d.size},          {"phases", d.phases},
                      {"spacing_mm", d.spacing}, {"bytes", d.volume_bytes}, {"repairs", d.repairs}};
  }
  json["upload"] = nullptr;
  if (d.upload) json["upload"] = to_json(*d.upload);
  json["labels"] = nullptr;
  if (d.owned() && d.state == DataSetState::kReady) json["labels"] = to_json(d.labels);
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

}  // namespace diaphane::api
