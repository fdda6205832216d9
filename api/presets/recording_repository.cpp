#include "api/presets/recording_repository.h"

namespace diaphane::api {
namespace {

Recording read_recording(const pqxx::row& row) {
  Recording recording;
  recording.id = row["id"].as<std::string>();
  recording.body = row["body"].as<std::string>();
  recording.events = row["events"].as<int>();
  recording.duration_ms = row["duration_ms"].as<std::int64_t>();
  recording.created_at = from_us(row["created_us"].as<std::int64_t>());
  recording.expires_at = from_us(row["expires_us"].as<std::int64_t>());
  return recording;
}

tl::unexpected<Error> no_recording() { return fail(ErrorCode::kNotFound, "Recording not found."); }

}  // namespace

Result<bool> RecordingRepository::consent(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<bool> {
    const auto rows = transaction.exec_params(
        "SELECT recording_consent_at IS NOT NULL AS consents FROM users WHERE id = $1::uuid",
        user_id);
    return !rows.empty() && rows[0]["consents"].as<bool>();
  });
}

Result<void> RecordingRepository::set_consent(const std::string& user_id, bool given, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(R"sql(
        UPDATE users
           SET recording_consent_at = CASE WHEN $2 THEN to_timestamp($3::bigint / 1e6) END
         WHERE id = $1::uuid)sql",
                             user_id, given, to_us(now));
    return {};
  });
}

Result<void> RecordingRepository::add(const std::string& user_id, const Recording& recording,
                                      std::int64_t most_bytes) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // The lock serialises concurrent additions and a withdrawal of the consent.
    const auto person = transaction.exec_params(
        "SELECT recording_consent_at IS NOT NULL AS consents FROM users WHERE id = $1::uuid FOR "
        "UPDATE",
        user_id);
    if (person.empty() || !person[0]["consents"].as<bool>()) {
      return fail(ErrorCode::kForbidden, "Recording is turned off.");
    }
    const auto sum = transaction.exec_params1(
        "SELECT COALESCE(sum(octet_length(body)), 0)::bigint AS bytes FROM recordings "
        "WHERE user_id = $1::uuid",
        user_id);
    if (sum["bytes"].as<std::int64_t>() + static_cast<std::int64_t>(recording.body.size()) >
        most_bytes) {
      return fail(ErrorCode::kTooLarge,
                  "You have reached the storage limit for recordings. Delete some first.");
    }
    transaction.exec_params0(R"sql(
        INSERT INTO recordings (id, user_id, body, events, duration_ms, created_at, expires_at)
        VALUES ($1::uuid, $2::uuid, $3, $4, $5, to_timestamp($6::bigint / 1e6),
                to_timestamp($7::bigint / 1e6)))sql",
                             recording.id, user_id, recording.body, recording.events,
                             recording.duration_ms, to_us(recording.created_at),
                             to_us(recording.expires_at));
    return {};
  });
}

Result<std::vector<Recording>> RecordingRepository::of(const std::string& user_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Recording>> {
    std::vector<Recording> recordings;
    for (const pqxx::row& row : transaction.exec_params(R"sql(
             SELECT id, '' AS body, events, duration_ms, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
                    (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us
               FROM recordings
              WHERE user_id = $1::uuid AND expires_at > to_timestamp($2::bigint / 1e6)
              ORDER BY created_at DESC, id)sql",
                                                        user_id, to_us(now))) {
      recordings.push_back(read_recording(row));
    }
    return recordings;
  });
}

Result<Recording> RecordingRepository::find(const std::string& user_id, const std::string& id,
                                            Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Recording> {
    const auto rows = transaction.exec_params(R"sql(
        SELECT id, body, events, duration_ms, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us
          FROM recordings
         WHERE user_id = $1::uuid AND id = $2::uuid AND expires_at > to_timestamp($3::bigint / 1e6))sql",
                                              user_id, id, to_us(now));
    if (rows.empty()) return no_recording();
    return read_recording(rows[0]);
  });
}

Result<void> RecordingRepository::remove(const std::string& user_id, const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "DELETE FROM recordings WHERE user_id = $1::uuid AND id = $2::uuid", user_id, id);
    if (done.affected_rows() == 0) return no_recording();
    return {};
  });
}

Result<void> RecordingRepository::expire(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        "DELETE FROM recordings WHERE expires_at <= to_timestamp($1::bigint / 1e6)", to_us(now));
    return {};
  });
}

}  // namespace diaphane::api
