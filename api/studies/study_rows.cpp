#include "api/studies/study_rows.h"

namespace diaphane::api {

Study read_study(const pqxx::row& row) {
  const auto time = [&](const char* column) -> std::optional<Time> {
    if (row[column].is_null()) return std::nullopt;
    return from_us(row[column].as<std::int64_t>());
  };
  Study study;
  study.id = row["id"].as<std::string>();
  study.owner_id = row["owner_id"].as<std::string>();
  study.content.title = row["title"].as<std::string>();
  study.content.places = row["places"].as<int>();
  study.content.ends_at = from_us(row["ends_us"].as<std::int64_t>());
  study.state = study_state_of(row["state"].as<std::string>());
  study.version = row["version"].as<int>();
  study.joined = row["joined"].as<int>();
  study.finished = row["done"].as<int>();
  study.withdrawn = row["withdrawn"].as<int>();
  study.created_at = from_us(row["created_us"].as<std::int64_t>());
  study.opened_at = time("opened_us");
  study.closed_at = time("closed_us");
  if (study.state == StudyState::kClosed && !study.closed_at) {
    study.closed_at = study.content.ends_at;
  }
  return study;
}

Participant read_participant(const pqxx::row& row) {
  Participant participant;
  participant.id = row["participant_id"].as<std::string>();
  participant.number = row["number"].as<int>();
  participant.key_hash = row["key_hash"].as<std::string>();
  participant.language = row["language"].as<std::string>();
  participant.seed = row["seed"].as<std::int64_t>();
  participant.day = row["day"].as<std::string>();
  participant.recorded = row["recorded"].as<bool>();
  participant.finished = row["finished"].as<bool>();
  participant.preview = row["preview"].as<bool>();
  participant.session_id = row["session_id"].as<std::string>();
  return participant;
}

}  // namespace diaphane::api
