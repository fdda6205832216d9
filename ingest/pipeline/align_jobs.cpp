#include "ingest/pipeline/align_jobs.h"

#include <utility>

#include "common/try.h"
#include "ingest/pipeline/postgres_link.h"

namespace diaphane::ingest {

struct PostgresAlignments::Impl : LeasedLink {
  using LeasedLink::LeasedLink;
};

PostgresAlignments::PostgresAlignments(LeaseOptions options)
    : impl_(std::make_unique<Impl>(std::move(options))) {}
PostgresAlignments::~PostgresAlignments() = default;

Result<std::optional<AlignJob>> PostgresAlignments::claim() {
  return impl_->transact([&](pqxx::work& transaction) -> std::optional<AlignJob> {
    // Returns the number of earlier attempts, and counts this one until it has a result.
    const auto rows = transaction.exec_params(
        R"sql(
        WITH next AS (
          SELECT a.moving, a.fixed FROM alignments a
            JOIN data_sets m ON m.id = a.moving JOIN data_sets f ON f.id = a.fixed
           WHERE a.state IN ('waiting', 'running') AND m.state = 'ready' AND f.state = 'ready'
             AND a.not_before <= now() AND (a.leased_until IS NULL OR a.leased_until <= now())
           ORDER BY a.created_at LIMIT 1 FOR UPDATE OF a SKIP LOCKED)
        UPDATE alignments a
           SET state = 'running', leased_by = $1, leased_until = now() + make_interval(secs => $2),
               attempts = attempts + 1
          FROM next WHERE a.moving = next.moving AND a.fixed = next.fixed
        RETURNING a.moving, a.fixed, a.attempts - 1 AS attempts, a.waits)sql",
        impl_->claimer, impl_->lease_seconds);
    if (rows.empty()) return std::nullopt;
    const pqxx::row row = rows[0];
    return AlignJob{row["moving"].as<std::string>(), row["fixed"].as<std::string>(),
                    row["attempts"].as<int>(), row["waits"].as<int>()};
  });
}

Result<bool> PostgresAlignments::renew(const AlignJob& job) {
  return impl_->transact([&](pqxx::work& transaction) {
    return transaction
               .exec_params(
                   R"sql(
                   UPDATE alignments SET leased_until = now() + make_interval(secs => $4)
                    WHERE moving = $1 AND fixed = $2 AND leased_by = $3 AND state = 'running')sql",
                   job.moving, job.fixed, impl_->claimer, impl_->lease_seconds)
               .affected_rows() > 0;
  });
}

Result<bool> PostgresAlignments::finish(const AlignJob& job, const RigidAlignment& found) {
  return impl_->transact([&](pqxx::work& transaction) {
    return transaction
               .exec_params(
                   R"sql(
                   UPDATE alignments
                      SET state = 'ready', matrix = string_to_array($4, ' ')::double precision[],
                          residual_mm = $5, overlap = $6, metric = $7, reason = NULL, leased_by = NULL, leased_until = NULL
                    WHERE moving = $1 AND fixed = $2 AND leased_by = $3 AND state = 'running')sql",
                   job.moving, job.fixed, impl_->claimer, volume::text_of(found.to_fixed),
                   found.residual_mm, found.overlap,
                   "mutual information " + std::to_string(found.information_before) + " to " +
                       std::to_string(found.information) + " nats")
               .affected_rows() > 0;
  });
}

Result<void> PostgresAlignments::fail_with(const AlignJob& job, const std::string& reason) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params(
            R"sql(
            UPDATE alignments SET state = 'failed', reason = $4, leased_by = NULL, leased_until = NULL
             WHERE moving = $1 AND fixed = $2 AND leased_by = $3 AND state = 'running')sql",
            job.moving, job.fixed, impl_->claimer, reason)
        .affected_rows();
  });
  DIAPHANE_TRY(done);
  return {};
}

Result<void> PostgresAlignments::put_back(const AlignJob& job, std::chrono::milliseconds pause,
                                          bool waiting, bool count_attempt) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params(
            R"sql(
            UPDATE alignments
               SET state = 'waiting', leased_by = NULL, leased_until = NULL,
                   waits = CASE WHEN $4::bool THEN waits + 1 ELSE waits END,
                   attempts = attempts - CASE WHEN $5::bool THEN 0 ELSE 1 END,
                   not_before = now() + make_interval(secs => $6)
             WHERE moving = $1 AND fixed = $2 AND leased_by = $3 AND state = 'running')sql",
            job.moving, job.fixed, impl_->claimer, waiting, count_attempt, seconds_of(pause))
        .affected_rows();
  });
  DIAPHANE_TRY(done);
  return {};
}

}  // namespace diaphane::ingest
