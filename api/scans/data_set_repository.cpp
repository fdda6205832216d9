#include "api/scans/data_set_repository.h"

#include <array>
#include <utility>

#include "api/accounts/account_repository.h"
#include "api/scans/data_set_rows.h"
#include "api/scans/view_rows.h"
#include "api/shared/audit_repository.h"
#include "api/shared/idempotency_rows.h"
#include "common/backup_lock.h"

namespace diaphane::api {
namespace {

/// Returns the owner as an SQL parameter. NULL means the operator of the sample. Queries must also
/// check is_sample, so that a deleted owner is never mistaken for the operator.
const char* owner_or_null(const Owner& owner) {
  return owner.user_id.empty() ? nullptr : owner.user_id.c_str();
}

void dispose_of(pqxx::work& transaction, const char* kind, const std::string& id, Time now) {
  transaction.exec_params0(R"sql(
      INSERT INTO disposals (kind, id, created_at) VALUES ($1, $2, to_timestamp($3::bigint / 1e6))
      ON CONFLICT DO NOTHING)sql",
                           kind, id, to_us(now));
}

tl::unexpected<Error> not_found() { return fail(ErrorCode::kNotFound, "Scan not found."); }

}  // namespace

Result<DataSetStore::Creation> DataSetRepository::create(const NewDataSet& data_set,
                                                         const DataSetLimits& limits,
                                                         const std::optional<IdempotencyKey>& key,
                                                         Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Creation> {
    const std::string& user_id = data_set.owner.user_id;
    const bool sample = user_id.empty();
    if (!sample) {
      const auto before = made_before(transaction, user_id, key);
      if (before && std::holds_alternative<KeyReused>(*before)) return KeyReused{};
      if (before) return std::get<Created>(*before);
      const Quota quota = lock_quota(transaction, user_id);
      if (data_set.bytes > quota.bytes - quota.used) return OverQuota{quota};
      const pqxx::row counts = transaction.exec_params1(R"sql(
          SELECT count(*) FILTER (WHERE d.state IN ('uploading', 'queued', 'building')
                                    AND d.volume_bytes IS NULL) AS unprocessed,
                 count(*) AS total
            FROM data_sets d WHERE d.owner_id = $1)sql",
                                                        user_id);
      if (counts["unprocessed"].as<int>() >= limits.unprocessed) return TooManyDataSets{true};
      if (counts["total"].as<int>() >= limits.all) return TooManyDataSets{false};
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO data_sets (id, owner_id, title, state, is_sample, visibility, published_at,
                               anonymised_at, created_at, updated_at)
        SELECT $1, $2, $3, 'uploading', $4::bool,
               CASE WHEN $4::bool THEN 'public' ELSE 'private' END,
               CASE WHEN $4::bool THEN t END, CASE WHEN $4::bool THEN t END, t, t
          FROM to_timestamp($5::bigint / 1e6) AS t)sql",
        data_set.id, owner_or_null(data_set.owner), data_set.title, sample, to_us(now));
    transaction.exec_params0(R"sql(
        INSERT INTO uploads (id, data_set_id, length, expires_at)
        VALUES ($1, $1, $2, to_timestamp($3::bigint / 1e6)))sql",
                             data_set.id, data_set.bytes, to_us(data_set.expires_at));
    note_made(transaction, user_id, key, data_set.id, now);
    return Created{data_set.id, false};
  });
}

Result<std::vector<DataSet>> DataSetRepository::list(const Viewer& viewer,
                                                     std::optional<Cursor> after, int limit) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<DataSet>> {
    if (!viewer.user_id.empty()) accept_invitations(transaction, viewer.user_id);
    const pqxx::result rows = transaction.exec_params(
        std::string(kSelectDataSet) + R"sql(
           AND (r.role <> 'other' OR d.is_sample)
           AND ($4::bool OR (d.created_at, d.id) < (to_timestamp($5::bigint / 1e6), $6::uuid))
         ORDER BY d.created_at DESC, d.id DESC LIMIT $7)sql",
        viewer_or_null(viewer), viewer.sample_operator, viewer.administrator, !after.has_value(),
        after ? after->created_us : std::int64_t{0}, after ? after->id.c_str() : nullptr, limit);
    std::vector<DataSet> found;
    for (const pqxx::row& row : rows) found.push_back(read_data_set(row));
    return found;
  });
}

Result<DataSet> DataSetRepository::find(const Viewer& viewer, const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<DataSet> {
    if (!viewer.user_id.empty()) accept_invitations(transaction, viewer.user_id);
    const pqxx::result rows = transaction.exec_params(
        std::string(kSelectDataSet) + " AND d.id = $4", viewer_or_null(viewer),
        viewer.sample_operator, viewer.administrator, id);
    if (rows.empty()) return not_found();
    return read_data_set(rows[0]);
  });
}

Result<void> DataSetRepository::describe(const std::string& id, const Description& what, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto text = [](const std::optional<std::string>& given) {
      return given ? given->c_str() : nullptr;
    };
    const pqxx::result changed = transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET title = COALESCE($2, title), description = COALESCE($3, description),
               body_part = CASE WHEN $4::text IS NULL THEN body_part ELSE NULLIF($4, '') END,
               updated_at = to_timestamp($5::bigint / 1e6)
         WHERE id = $1 RETURNING id)sql",
        id, text(what.title), text(what.text), text(what.body_part), to_us(now));
    if (changed.empty()) return not_found();
    return {};
  });
}

Result<void> DataSetRepository::remove(const Owner& owner, const std::string& id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result gone = transaction.exec_params(R"sql(
        DELETE FROM data_sets
         WHERE id = $2 AND (owner_id = $1::uuid OR ($1::uuid IS NULL AND owner_id IS NULL AND is_sample))
        RETURNING id)sql",
                                                      owner_or_null(owner), id);
    if (gone.empty()) return not_found();
    note_in_audit_log(transaction,
                      {owner.user_id.empty() ? AuditActor::kMachine : AuditActor::kPerson,
                       owner.user_id,
                       "data-set.deleted",
                       "data_set",
                       id,
                       {}},
                      now);
    dispose_of(transaction, "upload", id, now);
    dispose_of(transaction, "volume", id, now);
    return {};
  });
}

Result<Upload> DataSetRepository::find_upload(const Owner& owner, const std::string& id) {
  return database_.read([&](pqxx::work& transaction) -> Result<Upload> {
    // An expired upload no longer has a row in `uploads`, but its owner still sees its state.
    const pqxx::result rows = transaction.exec_params(R"sql(
        SELECT CASE WHEN NOT u.for_labels OR u.id IS NULL THEN d.state
                    WHEN u.received < u.length THEN 'uploading' ELSE 'queued' END AS state,
               COALESCE(u.length, 0) AS length, COALESCE(u.received, 0) AS received,
               COALESCE((extract(epoch FROM u.expires_at) * 1000000)::bigint, 0) AS expires_us
          FROM data_sets d LEFT JOIN uploads u ON u.data_set_id = d.id
         WHERE (u.id = $2 OR (d.id = $2 AND d.state = 'expired'))
           AND (d.owner_id = $1::uuid OR ($1::uuid IS NULL AND d.owner_id IS NULL AND d.is_sample)))sql",
                                                      owner_or_null(owner), id);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Upload not found.");
    return Upload{id, rows[0]["length"].as<std::int64_t>(), rows[0]["received"].as<std::int64_t>(),
                  from_us(rows[0]["expires_us"].as<std::int64_t>()),
                  data_set_state_of(rows[0]["state"].as<std::string>())};
  });
}

Result<void> DataSetRepository::advance_upload(const std::string& id, std::int64_t from,
                                               std::int64_t to, Time expires_at, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result moved = transaction.exec_params(
        R"sql(
        WITH standing AS (
          SELECT d.id FROM data_sets d JOIN uploads u ON u.data_set_id = d.id
           WHERE u.id = $1 AND d.state = CASE WHEN u.for_labels THEN 'ready' ELSE 'uploading' END
             FOR UPDATE OF d)
        UPDATE uploads SET received = $3, expires_at = to_timestamp($4::bigint / 1e6)
          FROM standing
         WHERE uploads.data_set_id = standing.id AND uploads.received = $2 AND uploads.received < uploads.length
        RETURNING uploads.length, uploads.for_labels, uploads.data_set_id)sql",
        id, from, to, to_us(expires_at));
    if (moved.empty())
      return fail(
          ErrorCode::kConflict,
          "More of the upload has arrived in the meantime. Check its offset and continue there.");
    if (moved[0]["length"].as<std::int64_t>() != to) return {};
    const bool for_labels = moved[0]["for_labels"].as<bool>();
    const auto data_set_id = moved[0]["data_set_id"].as<std::string>();
    transaction.exec_params0(R"sql(
        UPDATE data_sets SET state = CASE WHEN $3 THEN state ELSE 'queued' END,
                             updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1)sql",
                             data_set_id, to_us(now), for_labels);
    transaction.exec_params0(
        "INSERT INTO ingest_jobs (data_set_id, upload_id, for_labels) VALUES ($1, $2, $3)",
        data_set_id, id, for_labels);
    transaction.exec("NOTIFY ingest_jobs");
    return {};
  });
}

Result<void> DataSetRepository::cancel_upload(const Owner& owner, const std::string& id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result of_labels = transaction.exec_params(
        R"sql(
        SELECT u.received < u.length AS incomplete FROM uploads u JOIN data_sets d ON d.id = u.data_set_id
         WHERE u.id = $2 AND u.for_labels
           AND (d.owner_id = $1::uuid OR ($1::uuid IS NULL AND d.owner_id IS NULL AND d.is_sample))
           FOR UPDATE OF u)sql",
        owner_or_null(owner), id);
    if (!of_labels.empty()) {
      if (!of_labels[0]["incomplete"].as<bool>()) {
        return fail(ErrorCode::kConflict, "The upload is already complete.");
      }
      transaction.exec_params0("DELETE FROM uploads WHERE id = $1", id);
      return {};
    }
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT state FROM data_sets
         WHERE id = $2 AND (owner_id = $1::uuid OR ($1::uuid IS NULL AND owner_id IS NULL AND is_sample))
           FOR UPDATE)sql",
        owner_or_null(owner), id);
    if (found.empty()) return not_found();
    if (data_set_state_of(found[0]["state"].as<std::string>()) != DataSetState::kUploading) {
      return fail(ErrorCode::kConflict, "The upload is already complete.");
    }
    transaction.exec_params0("DELETE FROM data_sets WHERE id = $1", id);
    dispose_of(transaction, "upload", id, now);
    return {};
  });
}

Result<int> DataSetRepository::expire_uploads(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<int> {
    const pqxx::result late = transaction.exec_params(
        R"sql(
        SELECT u.id FROM uploads u JOIN data_sets d ON d.id = u.data_set_id
         WHERE (d.state = 'uploading' OR (u.for_labels AND u.received < u.length))
           AND u.expires_at <= to_timestamp($1::bigint / 1e6)
         ORDER BY u.expires_at LIMIT 100 FOR UPDATE OF d SKIP LOCKED)sql",
        to_us(now));
    for (const pqxx::row& row : late) {
      const auto id = row["id"].as<std::string>();
      transaction.exec_params0(R"sql(
          UPDATE data_sets SET state = 'expired', updated_at = to_timestamp($2::bigint / 1e6)
           WHERE id = $1 AND state = 'uploading')sql",
                               id, to_us(now));
      transaction.exec_params0("DELETE FROM uploads WHERE id = $1", id);
      dispose_of(transaction, "upload", id, now);
    }
    return static_cast<int>(late.size());
  });
}

namespace {

constexpr std::array<std::pair<Disposal::Kind, const char*>, 7> kDisposals{
    {{Disposal::Kind::kUpload, "upload"},
     {Disposal::Kind::kVolume, "volume"},
     {Disposal::Kind::kPictures, "pictures"},
     {Disposal::Kind::kExport, "export"},
     {Disposal::Kind::kPreset, "preset"},
     {Disposal::Kind::kEnvironment, "environment"},
     {Disposal::Kind::kScanExport, "scan-export"}}};

}  // namespace

Result<void> DataSetRepository::note_access(const AuditEntry& entry, Time not_since, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    note_once_in_audit_log(transaction, entry, not_since, now);
    return {};
  });
}

Result<void> DataSetRepository::note_view(const View& view, const AuditEntry& entry, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    note_views(transaction, {entry.subject_id}, view, now);
    note_once_in_audit_log(transaction, entry, now - kSameView, now);
    return {};
  });
}

Result<std::vector<ViewEntry>> DataSetRepository::views(const std::string& id,
                                                        const ViewQuery& query) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<ViewEntry>> {
    return read_views(transaction, id, query);
  });
}

Result<void> DataSetRepository::expire_views(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("DELETE FROM views WHERE last_at < to_timestamp($1::bigint / 1e6)",
                             to_us(now - kViewLife));
    return {};
  });
}

Result<std::vector<Disposal>> DataSetRepository::disposals(int limit) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Disposal>> {
    std::vector<Disposal> found;
    // Files stay while a backup copies them.
    const auto free =
        transaction.exec_params1("SELECT pg_try_advisory_xact_lock_shared($1)", kBackupLock)[0];
    if (!free.as<bool>()) return found;
    for (const auto& [kind, name] : kDisposals) {
      const pqxx::result rows = transaction.exec_params(
          "SELECT id FROM disposals WHERE kind = $1 ORDER BY created_at LIMIT $2", name, limit);
      for (const pqxx::row& row : rows) found.push_back({kind, row["id"].as<std::string>()});
    }
    return found;
  });
}

Result<void> DataSetRepository::disposed(const Disposal& disposal) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    for (const auto& [kind, name] : kDisposals) {
      if (kind != disposal.kind) continue;
      transaction.exec_params0("DELETE FROM disposals WHERE kind = $1 AND id = $2", name,
                               disposal.id);
    }
    return {};
  });
}

}  // namespace diaphane::api
