#include "ingest/pipeline/postgres_jobs.h"

#include <pqxx/pqxx>
#include <stdexcept>

#include "common/ids.h"
#include "common/log.h"
#include "common/postgres/connection.h"
#include "common/postgres/sql_fault.h"
#include "ingest/pipeline/moved_scene.h"

namespace diaphane::ingest {
namespace {

const char* name_of(volume::Modality modality) {
  switch (modality) {
    case volume::Modality::kCt:
      return "CT";
    case volume::Modality::kMr:
      return "MR";
    case volume::Modality::kPt:
      return "PT";
    case volume::Modality::kOther:
      break;
  }
  return "OTHER";
}

/// What people saved to look at the volume with stays where it was in the patient. What else the
/// documents held that some of them were read from may speak of what is gone, and nobody knows in
/// which coordinates: it goes. So does a preset that cannot be moved.
void move_presets(pqxx::work& transaction, const std::string& data_set,
                  const volume::Vector& shift) {
  const auto presets = transaction.exec_params(
      "SELECT id, scene FROM presets WHERE data_set_id = $1 FOR UPDATE", data_set);
  for (const pqxx::row& preset : presets) {
    const auto moved = moved_scene(preset[1].as<std::string>(), shift);
    const auto id = preset[0].as<std::string>();
    if (!moved) {
      transaction.exec_params("DELETE FROM presets WHERE id = $1", id);
      continue;
    }
    transaction.exec_params(
        R"sql(
        UPDATE presets SET scene = $2, kept_xml = NULL, pictured_at = NULL, version = version + 1,
                           updated_at = now()
         WHERE id = $1)sql",
        id, *moved);
  }
}

/// A text array as Postgres writes one.
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

}  // namespace

struct PostgresJobs::Impl {
  Impl(std::string url_, std::string claimer_, double lease_seconds_)
      : url(std::move(url_)), claimer(std::move(claimer_)), lease_seconds(lease_seconds_) {}

  static constexpr postgres::Patience kPatience{};
  std::string url;
  std::string claimer;
  double lease_seconds;
  SocketDeadlines deadlines{};  ///< outlives the connection
  std::unique_ptr<pqxx::connection> connection{};
  std::string last_state{};  ///< of the last SQL error: each kind is said once in a row

  pqxx::connection& connected() {
    if (connection) return *connection;
    connection = postgres::connect(url, "ingestd", kPatience, deadlines);
    return *connection;
  }

  /// Runs `work` in a transaction of its own and commits it. Ends within seconds, also when
  /// Postgres is frozen.
  template <typename Work>
  auto transact(Work work, postgres::CallSite where = postgres::CallSite::current())
      -> Result<decltype(work(std::declval<pqxx::work&>()))> {
    try {
      pqxx::connection& used = connected();
      const SocketDeadlines::Guard guard(deadlines, used.sock(),
                                         std::chrono::steady_clock::now() + kPatience.answer);
      pqxx::work transaction(used);
      auto value = work(transaction);
      transaction.commit();
      return value;
    } catch (const pqxx::broken_connection&) {
    } catch (const pqxx::in_doubt_error&) {
      // Committed or not: the caller asks again, and every question here may be asked twice.
    } catch (const pqxx::sql_error& error) {
      const std::string& state = error.sqlstate();
      const bool passing = state.starts_with("57") || state.starts_with("53") ||
                           state.starts_with("08") || state.starts_with("40") || state == "55P03";
      if (!passing && state != last_state) {
        log::error("sql_error", {{"reason", postgres::SqlFault(error, where).what()}});
      }
      last_state = state;
    } catch (const pqxx::failure&) {
    }
    connection.reset();
    return fail(ErrorCode::kUnavailable, "Postgres is away");
  }

  /// Ours and to be changed now: the data set is locked first, as `api` does, so that nobody waits
  /// in a ring.
  Hold take(pqxx::work& transaction, const Job& job) const {
    const auto data_set = transaction.exec_params(
        "SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", job.data_set_id);
    if (data_set.empty()) return Hold::kDeleted;
    const auto removed =
        transaction.exec_params("DELETE FROM ingest_jobs WHERE data_set_id = $1 AND leased_by = $2",
                                job.data_set_id, claimer);
    if (removed.affected_rows() == 0) return Hold::kLost;
    if (job.cut) return Hold::kOurs;
    transaction.exec_params("DELETE FROM uploads WHERE id = $1", job.upload_id);
    transaction.exec_params(
        "INSERT INTO disposals (kind, id) VALUES ('upload', $1) ON CONFLICT DO NOTHING",
        job.upload_id);
    return Hold::kOurs;
  }
};

PostgresJobs::PostgresJobs(std::string url, std::string claimer, std::chrono::milliseconds lease)
    : impl_(std::make_unique<Impl>(std::move(url), std::move(claimer),
                                   static_cast<double>(lease.count()) / 1000)) {}
PostgresJobs::~PostgresJobs() = default;

Result<std::optional<Job>> PostgresJobs::claim() {
  return impl_->transact([&](pqxx::work& transaction) -> std::optional<Job> {
    const auto rows = transaction.exec_params(
        R"sql(
        WITH next AS (
          SELECT j.data_set_id FROM ingest_jobs j JOIN data_sets d ON d.id = j.data_set_id
           WHERE j.not_before <= now() AND (j.leased_until IS NULL OR j.leased_until <= now())
           ORDER BY j.created_at LIMIT 1 FOR UPDATE OF d, j SKIP LOCKED),
        building AS (
          UPDATE data_sets d SET state = 'building', updated_at = now() FROM next
           WHERE d.id = next.data_set_id)
        UPDATE ingest_jobs j
           SET leased_by = $1, leased_until = now() + make_interval(secs => $2), attempts = attempts + 1
          FROM next WHERE j.data_set_id = next.data_set_id
        RETURNING j.data_set_id, COALESCE(j.upload_id::text, ''), j.attempts,
                  j.cut::text, COALESCE(j.cut_of, ''), COALESCE(j.cut_result, ''))sql",
        impl_->claimer, impl_->lease_seconds);
    if (rows.empty()) return std::nullopt;
    const pqxx::row row = rows[0];
    Job job{row[0].as<std::string>(), row[1].as<std::string>(), row[2].as<int>(), {}};
    if (!row[3].is_null()) {
      auto region = volume::region_from_json(row[3].as<std::string>());
      // `api` has read it the same way: what cannot be read now keeps nothing, and is refused.
      job.cut = CutOrder{region.value_or(volume::Region{}), row[4].as<std::string>(),
                         row[5].as<std::string>()};
    }
    return job;
  });
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
                                        std::uint64_t bytes, const std::string& head) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'ready', refusal_code = NULL, refusal_text = NULL, modality = $2,
               size_x = $3, size_y = $4, size_z = $5,
               spacing_x = $6, spacing_y = $7, spacing_z = $8,
               repairs = $9::text[], volume_bytes = $10, head = $11::jsonb, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, name_of(header.modality), static_cast<int>(header.size[0]),
        static_cast<int>(header.size[1]), static_cast<int>(header.size[2]), header.spacing[0],
        header.spacing[1], header.spacing[2], array_of(header.repairs),
        static_cast<std::int64_t>(bytes), head);
    return hold;
  });
}

Result<Hold> PostgresJobs::finish_refused(const Job& job, const std::string& code,
                                          const std::string& text) {
  return impl_->transact([&](pqxx::work& transaction) {
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'refused', refusal_code = $2, refusal_text = $3, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, code, text);
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
        SELECT asked_by, cut_shift[1], cut_shift[2], cut_shift[3] FROM ingest_jobs
         WHERE data_set_id = $1 AND cut_shift IS NOT NULL)sql",
        job.data_set_id);
    const Hold hold = impl_->take(transaction, job);
    if (hold != Hold::kOurs) return hold;
    transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET state = 'ready', anonymised_at = now(), cut_problem = NULL,
               size_x = $2, size_y = $3, size_z = $4, volume_bytes = $5, head = $6::jsonb, updated_at = now()
         WHERE id = $1)sql",
        job.data_set_id, static_cast<int>(header.size[0]), static_cast<int>(header.size[1]),
        static_cast<int>(header.size[2]), static_cast<std::int64_t>(bytes), head);
    transaction.exec_params(
        "INSERT INTO disposals (kind, id) VALUES ('pictures', $1) ON CONFLICT DO NOTHING",
        job.data_set_id);
    if (order.empty()) throw std::logic_error("a cut was finished that was never noted");
    const pqxx::row row = order[0];
    move_presets(transaction, job.data_set_id,
                 {row[1].as<double>(), row[2].as<double>(), row[3].as<double>()});
    transaction.exec_params(
        R"sql(
        INSERT INTO audit_log (happened_at, actor, actor_id, action, subject, subject_id, details)
        VALUES (now(), CASE WHEN $1::uuid IS NULL THEN 'machine' ELSE 'person' END, $1::uuid,
                'data-set.anonymised', 'data_set', $2::uuid, jsonb_build_object('voxels', $3::bigint)))sql",
        row[0].is_null() ? nullptr : row[0].c_str(), job.data_set_id,
        static_cast<std::int64_t>(header.voxel_count()));
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

Result<void> PostgresJobs::release(const Job& job) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    const auto data_set = transaction.exec_params(
        "SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", job.data_set_id);
    const auto given = transaction.exec_params(
        R"sql(
        UPDATE ingest_jobs SET leased_by = NULL, leased_until = NULL, attempts = attempts - 1
         WHERE data_set_id = $1 AND leased_by = $2)sql",
        job.data_set_id, impl_->claimer);
    if (given.affected_rows() > 0) {
      transaction.exec_params(
          "UPDATE data_sets SET state = 'queued', updated_at = now() WHERE id = $1",
          job.data_set_id);
    }
    return data_set.size();
  });
  if (!done) return tl::unexpected(done.error());
  return {};
}

Result<void> PostgresJobs::upload_removed(const std::string& upload_id) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params("DELETE FROM disposals WHERE kind = 'upload' AND id = $1", upload_id)
        .affected_rows();
  });
  if (!done) return tl::unexpected(done.error());
  return {};
}

Result<std::int64_t> PostgresJobs::queue_depth() {
  return impl_->transact([](pqxx::work& transaction) {
    return transaction.exec1("SELECT count(*) FROM ingest_jobs")[0].as<std::int64_t>();
  });
}

}  // namespace diaphane::ingest
