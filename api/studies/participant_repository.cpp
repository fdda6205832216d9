#include "api/studies/study_repository.h"
#include "api/studies/study_rows.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

/// Whether participants can take part at the time $1. A researcher who lost the role has no open
/// study.
constexpr const char* kOpen =
    " (u.is_researcher AND u.disabled_at IS NULL AND s.state = 'open' AND s.ends_at > "
    "to_timestamp($1::bigint / 1e6)) ";

/// Whether the participant or preview `p` can take part at the time $1.
const std::string kParticipates = std::string(" CASE WHEN p.preview_until IS NULL THEN") + kOpen +
                                  "ELSE u.is_researcher AND u.disabled_at IS NULL AND "
                                  "p.preview_until > to_timestamp($1::bigint / "
                                  "1e6) END ";

tl::unexpected<Error> no_participant() {
  return fail(ErrorCode::kNotFound, "There is no such participant.");
}

std::optional<Participation> find_by_key(pqxx::work& transaction, const std::string& key_hash,
                                         Time now) {
  const auto rows = transaction.exec_params("SELECT s.definition," + kParticipates + "AS open," +
                                                kParticipantColumns + "," + kStudyColumns + R"sql(
            FROM study_participants p JOIN studies s ON s.id = p.study_id JOIN users u ON u.id = s.owner_id
           WHERE p.key_hash = $2)sql",
                                            to_us(now), key_hash);
  if (rows.empty()) return std::nullopt;
  Participation found{read_participant(rows[0]), read_study(rows[0]), rows[0]["open"].as<bool>()};
  found.study.content.definition = rows[0]["definition"].as<std::string>();
  return found;
}

/// Locks the study of a participant, in the same order as a join.
void lock_study_of(pqxx::work& transaction, const std::string& key_hash) {
  transaction.exec_params(
      "SELECT 1 FROM studies WHERE id = (SELECT study_id FROM study_participants WHERE key_hash "
      "= $1) FOR UPDATE",
      key_hash);
}

struct Standing {
  std::string participant_id, study_id;
};

/// Locks the participant's row, so that a withdrawal either comes first or deletes what follows.
/// Returns kNotFound if there is none, or kConflict if the study has been closed since the request
/// was checked.
Result<Standing> lock_participant(pqxx::work& transaction, const std::string& key_hash, Time now) {
  transaction.exec_params("SELECT 1 FROM study_participants WHERE key_hash = $1 FOR UPDATE",
                          key_hash);
  const auto rows =
      transaction.exec_params("SELECT p.id, p.study_id," + kParticipates + R"sql(AS open
        FROM study_participants p JOIN studies s ON s.id = p.study_id JOIN users u ON u.id = s.owner_id
       WHERE p.key_hash = $2)sql",
                              to_us(now), key_hash);
  if (rows.empty()) return no_participant();
  if (!rows[0]["open"].as<bool>()) return fail(ErrorCode::kConflict, "This study is closed.");
  return Standing{rows[0]["id"].as<std::string>(), rows[0]["study_id"].as<std::string>()};
}

/// Makes room for another preview. The background task ends the sessions of the deleted ones.
void delete_oldest_previews(pqxx::work& transaction, const std::string& study_id) {
  transaction.exec_params0(
      R"sql(
      DELETE FROM study_participants WHERE id IN (
        SELECT id FROM study_participants WHERE study_id = $1::uuid AND preview_until IS NOT NULL
         ORDER BY preview_until DESC, id OFFSET $2::int - 1))sql",
      study_id, kMostPreviews);
}

/// Returns the number of a new participant. Previews have negative ones, so that the numbers of an
/// export are without gaps.
int next_number(pqxx::work& transaction, const std::string& study_id, bool preview) {
  if (preview) {
    return transaction
        .exec_params1(
            "SELECT LEAST(COALESCE(min(number), 0), 0) - 1 FROM study_participants WHERE study_id "
            "= "
            "$1::uuid",
            study_id)[0]
        .as<int>();
  }
  return transaction
      .exec_params1(
          "UPDATE studies SET next_number = next_number + 1 WHERE id = $1::uuid RETURNING "
          "next_number - 1",
          study_id)[0]
      .as<int>();
}

/// Checks, with the study locked, that a participant without a preview may join.
Result<void> check_join(pqxx::work& transaction, const std::string& study_id,
                        const std::string& key_hash, Time now) {
  const auto rows = transaction.exec_params("SELECT s.places," + std::string(kOpen) +
                                                R"sql(AS open,
          (SELECT count(*) FROM study_participants p WHERE p.study_id = s.id AND p.preview_until IS NULL)::int AS joined,
          EXISTS (SELECT FROM study_withdrawn_keys w WHERE w.key_hash = $3) AS withdrawn
          FROM studies s JOIN users u ON u.id = s.owner_id WHERE s.id = $2::uuid)sql",
                                            to_us(now), study_id, key_hash);
  if (rows.empty()) return fail(ErrorCode::kNotFound, "Study not found.");
  if (rows[0]["withdrawn"].as<bool>()) {
    return fail(ErrorCode::kConflict, "This participant withdrew.", "withdrawn");
  }
  if (!rows[0]["open"].as<bool>()) return fail(ErrorCode::kConflict, "This study is closed.");
  if (rows[0]["joined"].as<int>() >= rows[0]["places"].as<int>()) {
    return fail(ErrorCode::kTooMany, "All places of this study are taken.");
  }
  return {};
}

}  // namespace

Result<ParticipantStore::Invitation> ParticipantRepository::invitation(
    const std::string& token_hash, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Invitation> {
    const auto rows = transaction.exec_params(
        "SELECT s.definition, u.public_name," + std::string(kOpen) + "AS open," + kStudyColumns +
            "FROM studies s JOIN users u ON u.id = s.owner_id WHERE s.token_hash = $2",
        to_us(now), token_hash);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Study not found.");
    Invitation found{read_study(rows[0]), rows[0]["public_name"].as<std::string>(),
                     rows[0]["open"].as<bool>()};
    found.study.content.definition = rows[0]["definition"].as<std::string>();
    return found;
  });
}

Result<Participation> ParticipantRepository::join(const std::string& study_id,
                                                  const Participant& participant,
                                                  const std::optional<Time>& preview_until,
                                                  Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Participation> {
    // The lock serialises joins, so that each is counted, and a change of the definition. Only
    // later statements see what the transactions that it waited for have written.
    const auto locked =
        transaction.exec_params("SELECT 1 FROM studies WHERE id = $1::uuid FOR UPDATE", study_id);
    if (locked.empty()) return fail(ErrorCode::kNotFound, "Study not found.");
    if (auto known = find_by_key(transaction, participant.key_hash, now)) {
      if (known->study.id == study_id && known->participant.preview == preview_until.has_value()) {
        return *std::move(known);
      }
      return fail(ErrorCode::kConflict, "This key is already used.", "key");
    }
    if (preview_until) {
      delete_oldest_previews(transaction, study_id);
    } else {
      DIAPHANE_TRY(check_join(transaction, study_id, participant.key_hash, now));
    }
    const std::optional<std::int64_t> until =
        preview_until ? std::optional(to_us(*preview_until)) : std::nullopt;
    transaction.exec_params0(
        R"sql(
        INSERT INTO study_participants (id, study_id, number, key_hash, language, seed, day, recorded, preview_until)
        VALUES ($1::uuid, $2::uuid, $9, $3, $4, $5, $6::date, $7, to_timestamp($8::bigint / 1e6)))sql",
        participant.id, study_id, participant.key_hash, participant.language, participant.seed,
        participant.day, participant.recorded, until,
        next_number(transaction, study_id, preview_until.has_value()));
    auto joined = find_by_key(transaction, participant.key_hash, now);
    if (!joined) return no_participant();
    return *std::move(joined);
  });
}

Result<Participation> ParticipantRepository::find(const std::string& key_hash, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Participation> {
    auto found = find_by_key(transaction, key_hash, now);
    if (!found) return no_participant();
    return *std::move(found);
  });
}

Result<ParticipantStore::Answered> ParticipantRepository::answered(
    const std::string& participant_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<Answered> {
    Answered answered;
    for (const pqxx::row& row :
         transaction.exec_params("SELECT step, sequence FROM study_answers WHERE participant_id = "
                                 "$1::uuid ORDER BY sequence",
                                 participant_id)) {
      answered.steps.push_back(row["step"].as<std::string>());
      answered.sequence = row["sequence"].as<std::int64_t>();
    }
    return answered;
  });
}

Result<void> ParticipantRepository::answer(const std::string& key_hash, const StudyAnswer& answer,
                                           Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto found = lock_participant(transaction, key_hash, now);
    DIAPHANE_TRY(found);
    transaction.exec_params0(
        R"sql(
        INSERT INTO study_answers (participant_id, step, value, duration_ms, sequence)
        VALUES ($1::uuid, $2, $3, $4, $5)
        ON CONFLICT (participant_id, step) DO UPDATE
           SET value = excluded.value, duration_ms = excluded.duration_ms, sequence = excluded.sequence
         WHERE study_answers.sequence < excluded.sequence)sql",
        found->participant_id, answer.step, answer.value, answer.duration_ms, answer.sequence);
    return {};
  });
}

Result<void> ParticipantRepository::add_recording(const std::string& key_hash,
                                                  const std::string& step, const std::string& body,
                                                  const RecordingLimits& limits, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // The lock serialises the recordings of a study, so that each counts towards its limit.
    lock_study_of(transaction, key_hash);
    const auto found = lock_participant(transaction, key_hash, now);
    DIAPHANE_TRY(found);
    const auto stored = transaction.exec_params1(
        R"sql(
        SELECT COALESCE(sum(octet_length(r.body)), 0)::bigint AS by_all,
               COALESCE(sum(octet_length(r.body)) FILTER (WHERE p.id = $2::uuid), 0)::bigint AS by_one
          FROM study_recordings r JOIN study_participants p ON p.id = r.participant_id
         WHERE p.study_id = $1::uuid AND NOT (p.id = $2::uuid AND r.step = $3))sql",
        found->study_id, found->participant_id, step);
    const auto bytes = static_cast<std::int64_t>(body.size());
    if (stored["by_one"].as<std::int64_t>() + bytes > limits.per_participant ||
        stored["by_all"].as<std::int64_t>() + bytes > limits.per_study) {
      return fail(ErrorCode::kTooLarge, "The study can store no more recordings.");
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO study_recordings (participant_id, step, body) VALUES ($1::uuid, $2, $3)
        ON CONFLICT (participant_id, step) DO UPDATE SET body = excluded.body)sql",
        found->participant_id, step, body);
    return {};
  });
}

Result<void> ParticipantRepository::finish(const std::string& key_hash) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "UPDATE study_participants SET finished = true WHERE key_hash = $1", key_hash);
    if (done.affected_rows() == 0) return no_participant();
    return {};
  });
}

Result<std::string> ParticipantRepository::withdraw(const std::string& key_hash) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::string> {
    lock_study_of(transaction, key_hash);
    const auto gone = transaction.exec_params(
        R"sql(
        DELETE FROM study_participants WHERE key_hash = $1
        RETURNING study_id, preview_until IS NOT NULL AS preview, COALESCE(session_id::text, '') AS session_id)sql",
        key_hash);
    if (gone.empty()) return std::string();
    if (!gone[0]["preview"].as<bool>()) {
      transaction.exec_params0("UPDATE studies SET withdrawn = withdrawn + 1 WHERE id = $1::uuid",
                               gone[0]["study_id"].as<std::string>());
      transaction.exec_params0(
          "INSERT INTO study_withdrawn_keys (key_hash, study_id) VALUES ($1, $2::uuid)", key_hash,
          gone[0]["study_id"].as<std::string>());
    }
    return gone[0]["session_id"].as<std::string>();
  });
}

Result<void> ParticipantRepository::note_session(const std::string& key_hash,
                                                 const std::string& earlier,
                                                 const std::string& session_id, Time expires_at) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        R"sql(
        UPDATE study_participants SET session_id = $2::uuid, session_expires_at = to_timestamp($3::bigint / 1e6)
         WHERE key_hash = $1 AND (COALESCE(session_id::text, '') = $4 OR session_id = $2::uuid))sql",
        key_hash, session_id, to_us(expires_at), earlier);
    if (done.affected_rows() > 0) return {};
    const auto there =
        transaction.exec_params("SELECT 1 FROM study_participants WHERE key_hash = $1", key_hash);
    if (there.empty()) return no_participant();
    return fail(ErrorCode::kConflict, "The participant has another session by now.");
  });
}

}  // namespace diaphane::api
