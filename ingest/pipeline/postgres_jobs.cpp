#include "ingest/pipeline/postgres_jobs.h"

#include <pqxx/pqxx>
#include <stdexcept>

#include "common/backup_lock.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"
#include "ingest/pipeline/moved_scene.h"
#include "ingest/pipeline/postgres_link.h"
#include "ingest/pipeline/report.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

/// Moves saved presets so that they stay in place relative to the patient. Documents that presets
/// were imported from may describe removed parts in unknown coordinates, so they are deleted. So
/// are presets that cannot be moved, and marks, whose texts may name the patient.
void move_presets(pqxx::work& transaction, const std::string& data_set,
                  const volume::Vector& shift) {
  const auto presets = transaction.exec_params(
      "SELECT id, scene FROM presets WHERE data_set_id = $1 FOR UPDATE", data_set);
  for (const pqxx::row& preset : presets) {
    const auto moved = moved_scene(preset["scene"].as<std::string>(), shift);
    const auto id = preset["id"].as<std::string>();
    if (!moved) {
      transaction.exec_params("DELETE FROM presets WHERE id = $1", id);
      continue;
    }
    transaction.exec_params(
        R"sql(
        UPDATE presets SET scene = $2, annotations = NULL, kept_xml = NULL, pictured_at = NULL, version = version + 1,
                           updated_at = now()
         WHERE id = $1)sql",
        id, *moved);
  }
}

/// Moves the tour likewise, or deletes it if it cannot be moved.
void move_tour(pqxx::work& transaction, const std::string& data_set, const volume::Vector& shift) {
  const auto found = transaction.exec_params(
      "DELETE FROM data_set_tours WHERE data_set_id = $1 RETURNING tour", data_set);
  if (found.empty()) return;
  const auto moved = moved_tour(found[0]["tour"].as<std::string>(), shift);
  if (!moved) return;
  transaction.exec_params("INSERT INTO data_set_tours (data_set_id, tour) VALUES ($1, $2)",
                          data_set, *moved);
}

/// Formats an array of texts for Postgres.
std::string array_of(const std::vector<std::string>& texts) {
  std::string array = "{";
  for (const std::string& text : texts) {
    if (array.size() > 1) array += ',';
    array += '"';
    for (const char c : text) {
      if (c == '"' || c == '\\') array += '\\';
      array += c;
    }
    array += '"';
  }
  return array + "}";
}

/// Selects the bytes that the quota of $1's owner leaves for $1, counted as in `api` (lock_quota):
/// volumes, labels, and the full length of uploads in progress. No row without an owner.
constexpr const char* kQuotaLeft = R"sql(
  SELECT GREATEST(0, o.quota_bytes - COALESCE((
           SELECT sum(COALESCE(d.volume_bytes, 0) + d.label_bytes + COALESCE(u.length, 0))
                    FILTER (WHERE d.state IN ('uploading', 'queued', 'building', 'ready'))
             FROM data_sets d LEFT JOIN uploads u ON u.data_set_id = d.id
            WHERE d.owner_id = o.id AND d.id <> $1), 0))::bigint AS quota_left
    FROM users o WHERE o.id = (SELECT owner_id FROM data_sets WHERE id = $1))sql";

/// Leases the next job to $1 for $2 seconds. $3 is the size of the largest upload that it may take
/// (0: any), and $4 the common prefix of the names of all claimers of this process.
///
/// A suspect was interrupted more than once. After ten minutes it is overdue, and no other job is
/// claimed before it.
constexpr const char* kClaimNext = R"sql(
  WITH held AS (
    SELECT interruptions FROM ingest_jobs
     WHERE leased_until > now() AND starts_with(leased_by, $4)),
  overdue AS (
    SELECT FROM ingest_jobs
     WHERE leased_by IS NULL AND interruptions > 1 AND not_before < now() - interval '10 minutes'),
  next AS (
    SELECT j.data_set_id, d.owner_id, j.for_labels
      FROM ingest_jobs j JOIN data_sets d ON d.id = j.data_set_id
      LEFT JOIN uploads u ON u.id = j.upload_id
      LEFT JOIN ingest_turns t ON t.user_id = d.owner_id
     WHERE j.not_before <= now() AND j.leased_by IS NULL
       AND NOT EXISTS (SELECT FROM held WHERE interruptions > 1)
       AND CASE WHEN j.interruptions > 1 THEN NOT EXISTS (SELECT FROM held)
                ELSE NOT EXISTS (SELECT FROM overdue) END
       AND ($3::bigint = 0 OR (NOT j.large AND COALESCE(u.length, d.volume_bytes, 0) <= $3::bigint))
       AND NOT EXISTS (SELECT FROM ingest_jobs r JOIN data_sets o ON o.id = r.data_set_id
                        WHERE r.leased_until > now() AND o.owner_id = d.owner_id)
     ORDER BY j.interruptions > 1, t.served_at NULLS FIRST, j.created_at
     LIMIT 1 FOR UPDATE OF d, j SKIP LOCKED),
  building AS (
    UPDATE data_sets d SET state = 'building', updated_at = now() FROM next
     WHERE d.id = next.data_set_id AND NOT next.for_labels),
  turn AS (
    INSERT INTO ingest_turns (user_id, served_at)
    SELECT owner_id, clock_timestamp() FROM next WHERE owner_id IS NOT NULL
    ON CONFLICT (user_id) DO UPDATE SET served_at = excluded.served_at)
  UPDATE ingest_jobs j
     SET leased_by = $1, leased_until = now() + make_interval(secs => $2)
    FROM next WHERE j.data_set_id = next.data_set_id
  RETURNING j.data_set_id, COALESCE(j.upload_id::text, '') AS upload_id, j.attempts,
            j.cut::text AS cut, COALESCE(j.cut_of, '') AS cut_of,
            COALESCE(j.cut_result, '') AS cut_result, j.waits,
            j.interruptions, j.for_labels)sql";

/// Reads a row of kClaimNext.
Job job_of(const pqxx::row& row) {
  Job job;
  job.data_set_id = row["data_set_id"].as<std::string>();
  job.upload_id = row["upload_id"].as<std::string>();
  job.attempts = row["attempts"].as<int>();
  job.waits = row["waits"].as<int>();
  job.interruptions = row["interruptions"].as<int>();
  job.labels = row["for_labels"].as<bool>();
  if (!row["cut"].is_null()) {
    auto region = volume::region_from_json(row["cut"].as<std::string>());
    // `api` validated the region with the same code. A region that is now invalid keeps nothing,
    // so the cut is refused.
    job.cut = CutOrder{region.value_or(volume::Region{}), row["cut_of"].as<std::string>(),
                       row["cut_result"].as<std::string>()};
  }
  return job;
}

}  // namespace

struct PostgresJobs::Impl : LeasedLink {
  explicit Impl(Options options)
      : LeasedLink({std::move(options.url), std::move(options.claimer), options.lease}, kChannel),
        process(std::move(options.process)),
        first_pause_seconds(seconds_of(options.first_pause)),
        longest_pause_seconds(seconds_of(options.longest_pause)),
        light_bytes(static_cast<std::int64_t>(options.light_bytes)) {}

  /// `api` notifies it of everything that this program has to do.
  static constexpr const char* kChannel = "ingest_jobs";

  std::string process;
  double first_pause_seconds;
  double longest_pause_seconds;
  std::int64_t light_bytes;

  static void refuse(pqxx::work& transaction, const Job& job, const std::string& code,
                     const std::string& text) {
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'refused', refusal_code = $2, refusal_text = $3, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, code, text);
  }

  /// Requeues the job after `pause` if this claimer still holds it.
  Result<void> put_back(const Job& job, const char* waiting_for, std::chrono::milliseconds pause,
                        bool count_attempt, bool to_large) {
    auto done = transact([&](pqxx::work& transaction) {
      const auto data_set = transaction.exec_params(
          "SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", job.data_set_id);
      const auto updated = transaction.exec_params(
          R"sql(
          UPDATE ingest_jobs
             SET leased_by = NULL, leased_until = NULL,
                 attempts = attempts + CASE WHEN $3::bool THEN 1 ELSE 0 END,
                 waiting_for = $4::text, waits = CASE WHEN $4::text IS NULL THEN 0 ELSE waits + 1 END,
                 not_before = now() + make_interval(secs => $5), large = large OR $6::bool
           WHERE data_set_id = $1 AND leased_by = $2)sql",
          job.data_set_id, claimer, count_attempt, waiting_for, seconds_of(pause), to_large);
      if (updated.affected_rows() > 0) {
        transaction.exec_params(
            "UPDATE data_sets SET state = 'queued', updated_at = now() WHERE id = $1 AND NOT $2",
            job.data_set_id, job.labels);
      }
      return data_set.size();
    });
    DIAPHANE_TRY(done);
    return {};
  }

  /// Requeues jobs whose claimers ended.
  void put_back_interrupted(pqxx::work& transaction) const {
    const auto rows = transaction.exec_params(
        R"sql(
        WITH lost AS (
          SELECT j.data_set_id, j.for_labels,
                 CASE WHEN j.interruptions = 0 THEN 0
                      ELSE LEAST($1 * 2 ^ LEAST(j.interruptions - 1, 20), $2) END AS pause
            FROM ingest_jobs j JOIN data_sets d ON d.id = j.data_set_id
           WHERE j.leased_until <= now() FOR UPDATE OF d, j SKIP LOCKED),
        queued AS (
          UPDATE data_sets d SET state = 'queued', updated_at = now() FROM lost
           WHERE d.id = lost.data_set_id AND NOT lost.for_labels)
        UPDATE ingest_jobs j
           SET leased_by = NULL, leased_until = NULL, interruptions = interruptions + 1,
               waiting_for = 'interruption', not_before = now() + make_interval(secs => lost.pause)
          FROM lost WHERE j.data_set_id = lost.data_set_id
        RETURNING j.data_set_id, j.interruptions, lost.pause)sql",
        first_pause_seconds, longest_pause_seconds);
    for (const pqxx::row& row : rows) {
      log::warning("job_interrupted", {{"data_set", row["data_set_id"].as<std::string>()},
                                       {"interruptions", row["interruptions"].as<int>()},
                                       {"pause_s", row["pause"].as<double>()}});
    }
  }

  /// Locks the job for a change if this claimer holds it. Locks the data set first, as `api` does,
  /// to avoid a deadlock.
  Hold take(pqxx::work& transaction, const Job& job) const {
    const auto data_set = transaction.exec_params(
        "SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", job.data_set_id);
    if (data_set.empty()) return Hold::kDeleted;
    const auto removed =
        transaction.exec_params("DELETE FROM ingest_jobs WHERE data_set_id = $1 AND leased_by = $2",
                                job.data_set_id, claimer);
    if (removed.affected_rows() == 0) return Hold::kLost;
    // Another worker of this program may now take the owner's next job.
    transaction.exec(std::string("NOTIFY ") + kChannel);
    if (job.cut) return Hold::kOurs;
    transaction.exec_params("DELETE FROM uploads WHERE id = $1", job.upload_id);
    transaction.exec_params(
        "INSERT INTO disposals (kind, id) VALUES ('upload', $1) ON CONFLICT DO NOTHING",
        job.upload_id);
    return Hold::kOurs;
  }
};

PostgresJobs::PostgresJobs(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
PostgresJobs::~PostgresJobs() = default;

Result<std::optional<Job>> PostgresJobs::claim() {
  return impl_->transact([&](pqxx::work& transaction) -> std::optional<Job> {
    // Serialises claims, so that two workers never take jobs of one account at the same time.
    transaction.exec("SELECT pg_advisory_xact_lock(hashtext('diaphane ingest claim'))");
    impl_->put_back_interrupted(transaction);
    const auto rows = transaction.exec_params(kClaimNext, impl_->claimer, impl_->lease_seconds,
                                              impl_->light_bytes, impl_->process);
    if (rows.empty()) return std::nullopt;
    Job job = job_of(rows[0]);
    if (job.cut) return job;
    const auto left = transaction.exec_params(kQuotaLeft, job.data_set_id);
    if (!left.empty()) job.quota_left = left[0]["quota_left"].as<std::uint64_t>();
    return job;
  });
}

bool PostgresJobs::wait_for_work(std::chrono::milliseconds longest) {
  return impl_->wait_for_notification(longest);
}

Result<Hold> PostgresJobs::renew(const Job& job) {
  return impl_->transact([&](pqxx::work& transaction) {
    const auto renewed = transaction.exec_params(
        R"sql(
        UPDATE ingest_jobs SET leased_until = now() + make_interval(secs => $3)
         WHERE data_set_id = $1 AND leased_by = $2)sql",
        job.data_set_id, impl_->claimer, impl_->lease_seconds);
    if (renewed.affected_rows() > 0) return Hold::kOurs;
    const auto left =
        transaction.exec_params("SELECT 1 FROM data_sets WHERE id = $1", job.data_set_id);
    return left.empty() ? Hold::kDeleted : Hold::kLost;
  });
}

Result<Hold> PostgresJobs::finish_ready(const Job& job, const volume::Header& header,
                                        std::uint64_t bytes, const std::string& head,
                                        const std::string& frame) {
  return impl_->transact([&](pqxx::work& transaction) {
    // Locks the owner first, as `api` does. If two volumes finish at the same time, the second one
    // sees the first.
    transaction.exec_params(
        R"sql(
        SELECT 1 FROM users WHERE id = (SELECT owner_id FROM data_sets WHERE id = $1)
           FOR UPDATE)sql",
        job.data_set_id);
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    const auto left = transaction.exec_params(kQuotaLeft, job.data_set_id);
    if (!left.empty() && bytes > left[0]["quota_left"].as<std::uint64_t>()) {
      const Verdict refusal = over_quota(bytes, left[0]["quota_left"].as<std::uint64_t>());
      impl_->refuse(transaction, job, refusal.code, refusal.text);
      transaction.exec_params(
          "INSERT INTO disposals (kind, id) VALUES ('volume', $1) ON CONFLICT DO NOTHING",
          job.data_set_id);
      return Hold::kOverQuota;
    }
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'ready', refusal_code = NULL, refusal_text = NULL, modality = $2,
               size_x = $3, size_y = $4, size_z = $5,
               spacing_x = $6, spacing_y = $7, spacing_z = $8,
               repairs = $9::text[], volume_bytes = $10, head = $11::jsonb, phases = $12,
               frame_of_reference = CASE WHEN $13 <> '' THEN encode(sha256(convert_to(
                   COALESCE((SELECT frame_key::text FROM users WHERE users.id = owner_id), '') || $13, 'UTF8')), 'hex') END,
               updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, volume::name_of(header.modality), static_cast<int>(header.size[0]),
        static_cast<int>(header.size[1]), static_cast<int>(header.size[2]), header.spacing[0],
        header.spacing[1], header.spacing[2], array_of(header.repairs),
        static_cast<std::int64_t>(bytes), head, static_cast<int>(header.phase_count()), frame);
    return hold;
  });
}

Result<Hold> PostgresJobs::finish_refused(const Job& job, const std::string& code,
                                          const std::string& text) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold == Hold::kOurs) impl_->refuse(transaction, job, code, text);
    return hold;
  });
}

Result<Hold> PostgresJobs::note_cut(const Job& job, const std::string& content_hash,
                                    const volume::Vector& shift) {
  return impl_->transact([&](pqxx::work& transaction) {
    const auto noted = transaction.exec_params(
        R"sql(
        UPDATE ingest_jobs SET cut_result = $3, cut_shift = ARRAY[$4, $5, $6]::double precision[],
               leased_until = now() + make_interval(secs => $7)
         WHERE data_set_id = $1 AND leased_by = $2)sql",
        job.data_set_id, impl_->claimer, content_hash, shift[0], shift[1], shift[2],
        impl_->lease_seconds);
    if (noted.affected_rows() > 0) return Hold::kOurs;
    const auto left =
        transaction.exec_params("SELECT 1 FROM data_sets WHERE id = $1", job.data_set_id);
    return left.empty() ? Hold::kDeleted : Hold::kLost;
  });
}

Result<Hold> PostgresJobs::finish_cut(const Job& job, const volume::Header& header,
                                      std::uint64_t bytes, const std::string& head) {
  return impl_->transact([&](pqxx::work& transaction) {
    const auto order = transaction.exec_params(
        R"sql(
        SELECT asked_by, cut_shift[1] AS shift_x, cut_shift[2] AS shift_y, cut_shift[3] AS shift_z
          FROM ingest_jobs
         WHERE data_set_id = $1 AND cut_shift IS NOT NULL)sql",
        job.data_set_id);
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'ready', anonymised_at = now(), cut_problem = NULL, label_bytes = 0,
               label_count = 0, label_refusal_code = NULL, label_refusal_text = NULL,
               size_x = $2, size_y = $3, size_z = $4, volume_bytes = $5, head = $6::jsonb, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, static_cast<int>(header.size[0]), static_cast<int>(header.size[1]),
        static_cast<int>(header.size[2]), static_cast<std::int64_t>(bytes), head);
    transaction.exec_params(
        "INSERT INTO disposals (kind, id) VALUES ('pictures', $1) ON CONFLICT DO NOTHING",
        job.data_set_id);
    if (order.empty())
      throw std::logic_error("an anonymisation was finished without a recorded order");
    const pqxx::row row = order[0];
    transaction.exec_params("DELETE FROM annotations WHERE data_set_id = $1", job.data_set_id);
    const volume::Vector shift{row["shift_x"].as<double>(), row["shift_y"].as<double>(),
                               row["shift_z"].as<double>()};
    move_presets(transaction, job.data_set_id, shift);
    move_tour(transaction, job.data_set_id, shift);
    transaction.exec_params(
        R"sql(
        INSERT INTO audit_log (happened_at, actor, actor_id, action, subject, subject_id, details)
        VALUES (now(), CASE WHEN $1::uuid IS NULL THEN 'machine' ELSE 'person' END, $1::uuid,
                'data-set.anonymised', 'data_set', $2::uuid, jsonb_build_object('voxels', $3::bigint)))sql",
        row["asked_by"].is_null() ? nullptr : row["asked_by"].c_str(), job.data_set_id,
        static_cast<std::int64_t>(header.total_voxel_count()));
    return hold;
  });
}

Result<Hold> PostgresJobs::finish_cut_refused(const Job& job, const std::string& text) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        "UPDATE data_sets SET state = 'ready', cut_problem = $2, updated_at = now() WHERE id = $1",
        job.data_set_id, text);
    return hold;
  });
}

Result<Hold> PostgresJobs::finish_labels(const Job& job, const volume::LabelSet& labels,
                                         std::uint64_t bytes) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET label_bytes = $2, label_count = $3, label_refusal_code = NULL,
               label_refusal_text = NULL, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, static_cast<std::int64_t>(bytes), static_cast<int>(labels.table.size()));
    return hold;
  });
}

Result<Hold> PostgresJobs::finish_labels_refused(const Job& job, const std::string& code,
                                                 const std::string& text) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets SET label_refusal_code = $2, label_refusal_text = $3, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, code, text);
    return hold;
  });
}

Result<void> PostgresJobs::release(const Job& job) {
  return impl_->put_back(job, nullptr, {}, false, false);
}

Result<void> PostgresJobs::wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                                bool count_attempt) {
  return impl_->put_back(job, to_string(reason), pause, count_attempt, false);
}

Result<void> PostgresJobs::leave_to_large(const Job& job) {
  return impl_->put_back(job, nullptr, {}, false, true);
}

Result<bool> PostgresJobs::files_are_kept() {
  return impl_->transact([](pqxx::work& transaction) {
    const auto row =
        transaction.exec_params1("SELECT pg_try_advisory_xact_lock_shared($1)", kBackupLock);
    return !row[0].as<bool>();
  });
}

Result<void> PostgresJobs::upload_removed(const std::string& upload_id) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params("DELETE FROM disposals WHERE kind = 'upload' AND id = $1", upload_id)
        .affected_rows();
  });
  DIAPHANE_TRY(done);
  return {};
}

Result<QueueState> PostgresJobs::queue() {
  return impl_->transact([](pqxx::work& transaction) {
    const auto row = transaction.exec1(
        R"sql(
        SELECT count(*) AS jobs, count(waiting_for) AS waiting,
               count(*) FILTER (WHERE interruptions > 1) AS suspects
          FROM ingest_jobs)sql");
    return QueueState{row["jobs"].as<std::int64_t>(), row["waiting"].as<std::int64_t>(),
                      row["suspects"].as<std::int64_t>()};
  });
}

}  // namespace diaphane::ingest
