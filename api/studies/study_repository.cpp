#include "api/studies/study_repository.h"

#include "api/shared/audit_repository.h"
#include "api/shared/idempotency_rows.h"
#include "api/studies/study_rows.h"

namespace diaphane::api {
namespace {

tl::unexpected<Error> no_study() { return fail(ErrorCode::kNotFound, "Study not found."); }

void note_study(pqxx::work& transaction, const std::string& owner_id, const std::string& id,
                const std::string& action, Time now) {
  note_in_audit_log(transaction, {AuditActor::kPerson, owner_id, action, "study", id, {}}, now);
}

/// Locks a study, so that concurrent changes to it and joins are serialised. Returns its row. The
/// second statement sees what the transactions that the lock waited for have written.
pqxx::result lock_study(pqxx::work& transaction, const std::string& owner_id,
                        const std::string& id) {
  transaction.exec_params("SELECT 1 FROM studies WHERE id = $1::uuid FOR UPDATE", id);
  return transaction.exec_params(
      R"sql(
      SELECT s.version, s.state,
             s.withdrawn > 0 OR EXISTS (SELECT FROM study_participants p
                                         WHERE p.study_id = s.id AND p.preview_until IS NULL) AS begun
        FROM studies s WHERE s.id = $1::uuid AND s.owner_id = $2::uuid)sql",
      id, owner_id);
}

StudyStore::SessionIds sessions_of(pqxx::work& transaction, const std::string& id) {
  StudyStore::SessionIds sessions;
  for (const pqxx::row& row : transaction.exec_params(
           "SELECT session_id FROM study_participants WHERE study_id = $1::uuid AND session_id IS "
           "NOT NULL",
           id)) {
    sessions.push_back(row[0].as<std::string>());
  }
  return sessions;
}

tl::unexpected<Error> already_begun() {
  return fail(ErrorCode::kConflict,
              "Somebody has joined this study, so it can't be changed. Copy it to change it.");
}

}  // namespace

Result<std::variant<Created, KeyReused>> StudyRepository::create(
    const Study& study, int most, const std::optional<IdempotencyKey>& key) {
  using Answer = std::variant<Created, KeyReused>;
  return database_.transact([&](pqxx::work& transaction) -> Result<Answer> {
    if (const auto before = made_before(transaction, study.owner_id, key)) return *before;
    // The lock serialises concurrent creations, so that each is counted.
    transaction.exec_params("SELECT 1 FROM users WHERE id = $1::uuid FOR UPDATE", study.owner_id);
    const auto number = transaction.exec_params1(
        "SELECT count(*)::int AS number FROM studies WHERE owner_id = $1::uuid", study.owner_id);
    if (number["number"].as<int>() >= most) {
      return fail(ErrorCode::kTooMany,
                  "You have as many studies as an account can hold. Delete one first.");
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO studies (id, owner_id, definition, title, places, ends_at, state, created_at)
        VALUES ($1::uuid, $2::uuid, $3, $4, $5, to_timestamp($6::bigint / 1e6), 'draft',
                to_timestamp($7::bigint / 1e6)))sql",
        study.id, study.owner_id, study.content.definition, study.content.title,
        study.content.places, to_us(study.content.ends_at), to_us(study.created_at));
    note_made(transaction, study.owner_id, key, study.id, study.created_at);
    return Created{study.id, false};
  });
}

Result<std::vector<Study>> StudyRepository::of(const std::string& owner_id,
                                               const std::optional<Cursor>& after, int limit,
                                               Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Study>> {
    std::vector<Study> found;
    for (const pqxx::row& row :
         transaction.exec_params("SELECT" + std::string(kStudyColumns) + R"sql(
               FROM studies s
              WHERE s.owner_id = $2::uuid
                AND ($5::bool OR (s.created_at, s.id) < (to_timestamp($3::bigint / 1e6), $4::uuid))
              ORDER BY s.created_at DESC, s.id DESC LIMIT $6)sql",
                                 to_us(now), owner_id, after ? after->created_us : std::int64_t{0},
                                 after ? after->id.c_str() : nullptr, !after.has_value(), limit)) {
      found.push_back(read_study(row));
    }
    return found;
  });
}

Result<Study> StudyRepository::find(const std::string& owner_id, const std::string& id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Study> {
    const auto rows = transaction.exec_params(
        "SELECT s.definition," + std::string(kStudyColumns) +
            "FROM studies s WHERE s.owner_id = $2::uuid AND s.id = $3::uuid",
        to_us(now), owner_id, id);
    if (rows.empty()) return no_study();
    Study study = read_study(rows[0]);
    study.content.definition = rows[0]["definition"].as<std::string>();
    return study;
  });
}

Result<StudyStore::SessionIds> StudyRepository::replace(const std::string& owner_id,
                                                        const std::string& id, int version,
                                                        const std::set<std::string>& pictures,
                                                        const StudyContent& content) {
  return database_.transact([&](pqxx::work& transaction) -> Result<SessionIds> {
    const auto row = lock_study(transaction, owner_id, id);
    if (row.empty()) return no_study();
    if (row[0]["begun"].as<bool>()) return already_begun();
    if (row[0]["version"].as<int>() != version) {
      return fail(ErrorCode::kConflict, "Someone has changed this study in the meantime.",
                  "version");
    }
    // A study that changes is checked again before people can join it.
    transaction.exec_params0(
        R"sql(
        UPDATE studies SET definition = $2, title = $3, places = $4, ends_at = to_timestamp($5::bigint / 1e6),
                           version = version + 1, state = 'draft', opened_at = NULL, closed_at = NULL
         WHERE id = $1::uuid)sql",
        id, content.definition, content.title, content.places, to_us(content.ends_at));
    std::string kept;  // IDs have no comma
    for (const std::string& one : pictures) kept += one + ",";
    transaction.exec_params0(
        "DELETE FROM study_pictures WHERE study_id = $1::uuid AND picture_id <> "
        "ALL(string_to_array($2, ','))",
        id, kept);
    // The answers of a preview may not fit the new steps.
    SessionIds sessions = sessions_of(transaction, id);
    transaction.exec_params0(
        "DELETE FROM study_participants WHERE study_id = $1::uuid AND preview_until IS NOT NULL",
        id);
    return sessions;
  });
}

Result<StudyStore::SessionIds> StudyRepository::remove(const std::string& owner_id,
                                                       const std::string& id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<SessionIds> {
    if (lock_study(transaction, owner_id, id).empty()) return no_study();
    SessionIds sessions = sessions_of(transaction, id);
    transaction.exec_params0("DELETE FROM studies WHERE id = $1::uuid", id);
    note_study(transaction, owner_id, id, "study.deleted", now);
    return sessions;
  });
}

Result<StudyStore::SessionIds> StudyRepository::set_state(const std::string& owner_id,
                                                          const std::string& id, int version,
                                                          StudyState state, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<SessionIds> {
    const auto row = lock_study(transaction, owner_id, id);
    if (row.empty()) return no_study();
    if (row[0]["state"].as<std::string>() == to_string(state)) return SessionIds{};
    const bool opens = state == StudyState::kOpen;
    if (!opens && row[0]["state"].as<std::string>() == "draft") {
      return fail(ErrorCode::kConflict, "This study is a draft. Only an open study can be closed.");
    }
    if (opens && row[0]["version"].as<int>() != version) {
      return fail(ErrorCode::kConflict,
                  "Someone has changed this study in the meantime. Try again.");
    }
    // Waits for an administrator who is withdrawing the role.
    const auto role = transaction.exec_params(
        "SELECT 1 FROM users WHERE id = $1::uuid AND is_researcher AND disabled_at IS NULL FOR "
        "SHARE",
        owner_id);
    if (role.empty()) return no_study();
    transaction.exec_params0(
        R"sql(
        UPDATE studies
           SET state = $2, opened_at = CASE WHEN $3 THEN COALESCE(opened_at, to_timestamp($4::bigint / 1e6)) ELSE opened_at END,
               closed_at = CASE WHEN $3 THEN NULL ELSE to_timestamp($4::bigint / 1e6) END
         WHERE id = $1::uuid)sql",
        id, std::string(to_string(state)), opens, to_us(now));
    note_study(transaction, owner_id, id, opens ? "study.opened" : "study.closed", now);
    return opens ? SessionIds{} : sessions_of(transaction, id);
  });
}

Result<void> StudyRepository::set_link(const std::string& owner_id, const std::string& id,
                                       const std::string& token_hash) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "UPDATE studies SET token_hash = $3 WHERE id = $1::uuid AND owner_id = $2::uuid", id,
        owner_id, token_hash);
    if (done.affected_rows() == 0) return no_study();
    return {};
  });
}

Result<void> StudyRepository::put_picture(const std::string& owner_id, const std::string& id,
                                          const StudyPicture& picture, int most) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto row = lock_study(transaction, owner_id, id);
    if (row.empty()) return no_study();
    if (row[0]["begun"].as<bool>()) return already_begun();
    const auto others = transaction.exec_params1(
        "SELECT count(*)::int AS number FROM study_pictures WHERE study_id = $1::uuid AND "
        "picture_id <> $2",
        id, picture.id);
    if (others["number"].as<int>() + 1 > most) {
      return fail(ErrorCode::kTooMany, "This study has as many pictures as it can hold.");
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO study_pictures (study_id, picture_id, type, bytes) VALUES ($1::uuid, $2, $3, $4)
        ON CONFLICT (study_id, picture_id) DO UPDATE SET type = excluded.type, bytes = excluded.bytes)sql",
        id, picture.id, picture.type,
        pqxx::binarystring(picture.bytes.data(), picture.bytes.size()));
    return {};
  });
}

Result<StudyPicture> StudyRepository::picture(const std::string& study_id,
                                              const std::string& picture_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<StudyPicture> {
    const auto rows = transaction.exec_params(
        "SELECT type, bytes FROM study_pictures WHERE study_id = $1::uuid AND picture_id = $2",
        study_id, picture_id);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Picture not found.");
    const pqxx::binarystring bytes(rows[0]["bytes"]);
    return StudyPicture{picture_id, rows[0]["type"].as<std::string>(), bytes.str()};
  });
}

Result<std::vector<std::string>> StudyRepository::pictures(const std::string& study_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> found;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT picture_id FROM study_pictures WHERE study_id = $1::uuid ORDER BY picture_id",
             study_id)) {
      found.push_back(row[0].as<std::string>());
    }
    return found;
  });
}

Result<std::vector<Participant>> StudyRepository::participants(const std::string& study_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Participant>> {
    std::vector<Participant> found;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT" + std::string(kParticipantColumns) +
                 "FROM study_participants p WHERE p.study_id = $1::uuid AND p.preview_until IS "
                 "NULL ORDER BY p.number",
             study_id)) {
      found.push_back(read_participant(row));
    }
    return found;
  });
}

Result<std::vector<StudyAnswer>> StudyRepository::answers(const std::string& participant_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<StudyAnswer>> {
    std::vector<StudyAnswer> found;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT step, value, duration_ms, sequence FROM study_answers WHERE participant_id = "
             "$1::uuid",
             participant_id)) {
      found.push_back({row["step"].as<std::string>(), row["value"].as<std::string>(),
                       row["duration_ms"].as<std::int64_t>(), row["sequence"].as<std::int64_t>()});
    }
    return found;
  });
}

Result<std::vector<StudyStore::Recorded>> StudyRepository::recordings(
    const std::string& participant_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Recorded>> {
    std::vector<Recorded> found;
    for (const pqxx::row& row :
         transaction.exec_params("SELECT step, body FROM study_recordings WHERE participant_id = "
                                 "$1::uuid ORDER BY step",
                                 participant_id)) {
      found.push_back({row["step"].as<std::string>(), row["body"].as<std::string>()});
    }
    return found;
  });
}

Result<void> StudyRepository::note_exported(const std::string& owner_id, const std::string& id,
                                            Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    note_study(transaction, owner_id, id, "study.exported", now);
    return {};
  });
}

Result<std::string> StudyRepository::owner_of(const std::string& id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::string> {
    const auto rows =
        transaction.exec_params("SELECT owner_id FROM studies WHERE id = $1::uuid", id);
    if (rows.empty()) return no_study();
    return rows[0][0].as<std::string>();
  });
}

Result<std::string> StudyRepository::comfort() {
  return database_.read([&](pqxx::work& transaction) -> Result<std::string> {
    const auto rows = transaction.exec("SELECT comfort FROM perception_comfort");
    return rows.empty() ? std::string() : rows[0][0].as<std::string>();
  });
}

Result<void> StudyRepository::set_comfort(const std::string& administrator_id,
                                          const std::string& study_id, const std::string& comfort,
                                          Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec0("DELETE FROM perception_comfort");
    if (!comfort.empty()) {
      transaction.exec_params0("INSERT INTO perception_comfort (comfort) VALUES ($1)", comfort);
    }
    note_in_audit_log(transaction,
                      {AuditActor::kAdministrator,
                       administrator_id,
                       comfort.empty() ? "comfort.reset" : "comfort.adopted",
                       "study",
                       study_id,
                       {}},
                      now);
    return {};
  });
}

Result<std::string> StudyRepository::tour(const std::string& data_set_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::string> {
    const auto rows = transaction.exec_params(
        "SELECT tour FROM data_set_tours WHERE data_set_id = $1::uuid", data_set_id);
    return rows.empty() ? std::string() : rows[0][0].as<std::string>();
  });
}

Result<void> StudyRepository::set_tour(const std::string& user_id, const std::string& data_set_id,
                                       const std::string& tour, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    if (tour.empty()) {
      transaction.exec_params0("DELETE FROM data_set_tours WHERE data_set_id = $1::uuid",
                               data_set_id);
    } else {
      transaction.exec_params0(
          R"sql(
          INSERT INTO data_set_tours (data_set_id, tour)
          SELECT id, $2 FROM data_sets WHERE id = $1::uuid
          ON CONFLICT (data_set_id) DO UPDATE SET tour = excluded.tour)sql",
          data_set_id, tour);
    }
    note_in_audit_log(transaction,
                      {AuditActor::kPerson,
                       user_id,
                       tour.empty() ? "data-set.tour-removed" : "data-set.tour-adopted",
                       "data_set",
                       data_set_id,
                       {}},
                      now);
    return {};
  });
}

Result<StudyStore::SessionIds> StudyRepository::expire(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<SessionIds> {
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             UPDATE studies SET state = 'closed', closed_at = ends_at
              WHERE state = 'open' AND ends_at <= to_timestamp($1::bigint / 1e6)
             RETURNING id)sql",
             to_us(now))) {
      note_in_audit_log(
          transaction,
          {AuditActor::kMachine, "", "study.closed", "study", row[0].as<std::string>(), {}}, now);
    }
    transaction.exec_params0(
        "DELETE FROM study_participants WHERE preview_until <= to_timestamp($1::bigint / 1e6)",
        to_us(now));
    SessionIds over;
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT p.session_id
               FROM study_participants p JOIN studies s ON s.id = p.study_id JOIN users u ON u.id = s.owner_id
              WHERE p.session_id IS NOT NULL
                AND (p.session_expires_at <= to_timestamp($1::bigint / 1e6)
                     OR NOT u.is_researcher OR u.disabled_at IS NOT NULL
                     OR (p.preview_until IS NULL AND s.state <> 'open'))
              UNION SELECT session_id FROM study_ended_sessions)sql",
             to_us(now))) {
      over.push_back(row[0].as<std::string>());
    }
    return over;
  });
}

Result<void> StudyRepository::forget_session(const std::string& session_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        "UPDATE study_participants SET session_id = NULL, session_expires_at = NULL WHERE "
        "session_id = $1::uuid",
        session_id);
    transaction.exec_params0("DELETE FROM study_ended_sessions WHERE session_id = $1::uuid",
                             session_id);
    return {};
  });
}

}  // namespace diaphane::api
