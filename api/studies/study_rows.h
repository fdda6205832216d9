#pragma once

#include "api/shared/database.h"
#include "api/studies/study.h"

/// Reading the rows of studies and participants.
namespace diaphane::api {

/// Selects studies `s` at the time $1, as `read_study` expects them. An open study that has ended is
/// closed, even before the background task has closed it.
inline constexpr const char* kStudyColumns = R"sql(
         s.id, s.owner_id, s.title, s.places, s.version, s.withdrawn,
         CASE WHEN s.state = 'open' AND s.ends_at <= to_timestamp($1::bigint / 1e6) THEN 'closed' ELSE s.state END AS state,
         (extract(epoch FROM s.ends_at) * 1000000)::bigint AS ends_us,
         (extract(epoch FROM s.created_at) * 1000000)::bigint AS created_us,
         (extract(epoch FROM s.opened_at) * 1000000)::bigint AS opened_us,
         (extract(epoch FROM s.closed_at) * 1000000)::bigint AS closed_us,
         (SELECT count(*) FROM study_participants p WHERE p.study_id = s.id AND p.preview_until IS NULL)::int AS joined,
         (SELECT count(*) FROM study_participants p
           WHERE p.study_id = s.id AND p.preview_until IS NULL AND p.finished)::int AS done )sql";

Study read_study(const pqxx::row& row);

inline constexpr const char* kParticipantColumns = R"sql(
         p.id AS participant_id, p.number, p.key_hash, p.language, p.seed, p.day::text AS day, p.recorded, p.finished,
         p.preview_until IS NOT NULL AS preview, COALESCE(p.session_id::text, '') AS session_id )sql";

Participant read_participant(const pqxx::row& row);

}  // namespace diaphane::api
