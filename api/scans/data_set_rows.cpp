#include "api/scans/data_set_rows.h"

#include <utility>

#include "common/names.h"

namespace diaphane::api {

// Data sets of a disabled account are invisible to everyone, and its owner sees no data sets at
// all. A deleted owner is never mistaken for the operator, because the rows are deleted with the
// owner and samples are selected by is_sample.
const char* const kSelectDataSet = R"sql(
  SELECT d.id, d.title, d.state, r.role, d.visibility = 'public' AS is_public, d.is_sample,
         COALESCE(d.refusal_code, '') AS refusal_code, COALESCE(d.refusal_text, '') AS refusal_text,
         COALESCE(d.modality, '') AS modality,
         COALESCE(d.size_x, 0) AS size_x, COALESCE(d.size_y, 0) AS size_y, COALESCE(d.size_z, 0) AS size_z,
         COALESCE(d.spacing_x, 0) AS spacing_x, COALESCE(d.spacing_y, 0) AS spacing_y,
         COALESCE(d.spacing_z, 0) AS spacing_z,
         COALESCE(d.volume_bytes, 0) AS volume_bytes, d.phases, d.repairs,
         (extract(epoch FROM d.created_at) * 1000000)::bigint AS created_us,
         (extract(epoch FROM d.updated_at) * 1000000)::bigint AS updated_us,
         u.length AS upload_length, u.received AS upload_received,
         (extract(epoch FROM u.expires_at) * 1000000)::bigint AS upload_expires_us,
         d.description, COALESCE(d.body_part, '') AS body_part, d.taken_down_at IS NOT NULL AS taken_down,
         COALESCE(d.taken_down_reason, '') AS taken_down_reason, COALESCE(o.public_name, '') AS owner_name,
         (extract(epoch FROM d.published_at) * 1000000)::bigint AS published_us,
         (extract(epoch FROM d.anonymised_at) * 1000000)::bigint AS anonymised_us,
         CASE WHEN r.role = 'owner' THEN (SELECT count(*) FROM data_set_people p WHERE p.data_set_id = d.id) ELSE 0 END AS people,
         CASE WHEN r.role = 'owner' THEN (SELECT count(*) FROM data_set_links l WHERE l.data_set_id = d.id AND l.expires_at > now()) ELSE 0 END AS links,
         CASE WHEN r.role = 'owner' AND d.state = 'queued' THEN COALESCE(j.waiting_for, '') ELSE '' END AS waiting_for,
         d.public_slices, d.public_downloads, COALESCE(s.slices, false) AS person_slices,
         COALESCE(s.downloads, false) AS person_downloads,
         d.label_count, d.label_bytes, COALESCE(d.label_refusal_code, '') AS label_refusal_code,
         COALESCE(d.label_refusal_text, '') AS label_refusal_text, COALESCE(j.for_labels, false) AS placing_labels,
         CASE WHEN u.for_labels THEN u.id END AS label_upload_id
    FROM data_sets d
    LEFT JOIN ingest_jobs j ON j.data_set_id = d.id
    LEFT JOIN uploads u ON u.data_set_id = d.id
    LEFT JOIN users o ON o.id = d.owner_id
    LEFT JOIN users v ON v.id = $1::uuid
    LEFT JOIN data_set_people s ON s.data_set_id = d.id AND s.user_id = $1::uuid
    CROSS JOIN LATERAL (SELECT CASE
        WHEN d.owner_id = $1::uuid OR ($2::bool AND d.is_sample AND d.owner_id IS NULL) THEN 'owner'
        WHEN s.may_save THEN 'shared-edit'
        WHEN NOT s.may_save THEN 'shared-view'
        WHEN v.id IS NULL THEN 'nobody'
        WHEN v.verified_at IS NULL THEN 'unverified'
        ELSE 'other' END AS role) r
   WHERE v.disabled_at IS NULL
     AND (r.role = 'owner'
          OR (d.state = 'ready'
              AND ((o.disabled_at IS NULL
                    AND (d.visibility = 'public'
                         OR (d.taken_down_at IS NULL AND r.role IN ('shared-edit', 'shared-view'))))
                   OR ($3::bool AND d.taken_down_at IS NOT NULL)))))sql";

namespace {

std::vector<std::string> read_texts(const pqxx::field& field) {
  std::vector<std::string> texts;
  auto parser = field.as_array();
  for (auto next = parser.get_next(); next.first != pqxx::array_parser::done;
       next = parser.get_next()) {
    if (next.first == pqxx::array_parser::string_value) texts.push_back(next.second);
  }
  return texts;
}

std::optional<Time> time_or_nothing(const pqxx::field& field) {
  if (field.is_null()) return std::nullopt;
  return from_us(field.as<std::int64_t>());
}

LabelState read_label_state(const pqxx::row& row) {
  LabelState labels;
  labels.count = row["label_count"].as<int>();
  labels.bytes = row["label_bytes"].as<std::int64_t>();
  labels.placing = row["placing_labels"].as<bool>();
  labels.refusal_code = row["label_refusal_code"].as<std::string>();
  labels.refusal_text = row["label_refusal_text"].as<std::string>();
  if (!labels.placing && !row["label_upload_id"].is_null()) {
    labels.upload =
        Upload{row["label_upload_id"].as<std::string>(), row["upload_length"].as<std::int64_t>(),
               row["upload_received"].as<std::int64_t>(),
               from_us(row["upload_expires_us"].as<std::int64_t>()), DataSetState::kUploading};
  }
  return labels;
}

}  // namespace

std::string shown_name(std::string name) {
  return is_plain_name(name) ? std::move(name) : std::string();
}

DataSet read_data_set(const pqxx::row& row) {
  DataSet d;
  d.id = row["id"].as<std::string>();
  d.title = row["title"].as<std::string>();
  d.state = data_set_state_of(row["state"].as<std::string>());
  d.role = role_of(row["role"].as<std::string>()).value_or(Role::kNobody);
  d.is_public = row["is_public"].as<bool>();
  d.is_sample = row["is_sample"].as<bool>();
  d.refusal_code = row["refusal_code"].as<std::string>();
  d.refusal_text = row["refusal_text"].as<std::string>();
  d.modality = row["modality"].as<std::string>();
  d.size = {row["size_x"].as<int>(), row["size_y"].as<int>(), row["size_z"].as<int>()};
  d.spacing = {row["spacing_x"].as<double>(), row["spacing_y"].as<double>(),
               row["spacing_z"].as<double>()};
  d.volume_bytes = row["volume_bytes"].as<std::int64_t>();
  d.phases = row["phases"].as<int>();
  d.repairs = read_texts(row["repairs"]);
  d.created_at = from_us(row["created_us"].as<std::int64_t>());
  d.updated_at = from_us(row["updated_us"].as<std::int64_t>());
  if (d.owned() && d.state == DataSetState::kUploading && !row["upload_length"].is_null()) {
    d.upload = Upload{d.id, row["upload_length"].as<std::int64_t>(),
                      row["upload_received"].as<std::int64_t>(),
                      from_us(row["upload_expires_us"].as<std::int64_t>()), d.state};
  }
  if (d.owned() && d.state == DataSetState::kReady) d.labels = read_label_state(row);
  d.description = row["description"].as<std::string>();
  d.body_part = row["body_part"].as<std::string>();
  d.taken_down = row["taken_down"].as<bool>();
  d.taken_down_reason = row["taken_down_reason"].as<std::string>();
  d.owner_name = shown_name(row["owner_name"].as<std::string>());
  d.published_at = time_or_nothing(row["published_us"]);
  d.anonymised_at = time_or_nothing(row["anonymised_us"]);
  d.people = row["people"].as<int>();
  d.links = row["links"].as<int>();
  d.waiting_for = row["waiting_for"].as<std::string>();
  d.to_public = {row["public_slices"].as<bool>(), row["public_downloads"].as<bool>()};
  d.to_person = {row["person_slices"].as<bool>(), row["person_downloads"].as<bool>()};
  return d;
}

void accept_invitations(pqxx::work& transaction, const std::string& user_id) {
  // A user who was invited at two of their addresses keeps the first invitation.
  transaction.exec_params0(R"sql(
      UPDATE data_set_people p SET user_id = u.id
        FROM users u
       WHERE u.id = $1::uuid AND u.verified_at IS NOT NULL AND p.user_id IS NULL
         AND p.email_key = u.email_key
         AND NOT EXISTS (SELECT 1 FROM data_set_people q
                          WHERE q.data_set_id = p.data_set_id AND q.user_id = u.id))sql",
                           user_id);
}

}  // namespace diaphane::api
