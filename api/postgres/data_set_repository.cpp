#include "api/postgres/data_set_repository.h"

#include "api/postgres/account_repository.h"

namespace diaphane::api {
namespace {

/// Whose it is, as SQL has it: NULL is the sample's operator. Compared by IS NOT DISTINCT FROM,
/// together with is_sample, so that an owner who was deleted can never be taken for the operator.
const char* owner_or_null(const Owner& owner) {
  return owner.user_id.empty() ? nullptr : owner.user_id.c_str();
}

// $1 is the viewer.
constexpr const char* kSelect = R"sql(
  SELECT d.id, d.title, d.state,
         d.owner_id IS NOT DISTINCT FROM $1::uuid AND ($1::uuid IS NOT NULL OR d.is_sample) AS owned,
         d.is_public, d.is_sample, COALESCE(d.refusal_code, ''), COALESCE(d.refusal_text, ''),
         COALESCE(d.modality, ''),
         COALESCE(d.size_x, 0), COALESCE(d.size_y, 0), COALESCE(d.size_z, 0),
         COALESCE(d.spacing_x, 0), COALESCE(d.spacing_y, 0), COALESCE(d.spacing_z, 0),
         COALESCE(d.volume_bytes, 0), d.repairs,
         (extract(epoch FROM d.created_at) * 1000000)::bigint,
         (extract(epoch FROM d.updated_at) * 1000000)::bigint,
         u.length, u.received, (extract(epoch FROM u.expires_at) * 1000000)::bigint
    FROM data_sets d LEFT JOIN uploads u ON u.data_set_id = d.id
   WHERE (d.owner_id = $1::uuid OR ($1::uuid IS NULL AND d.is_sample)
          OR (d.is_public AND d.state = 'ready')))sql";

std::vector<std::string> read_texts(const pqxx::field& field) {
  std::vector<std::string> texts;
  auto parser = field.as_array();
  for (auto next = parser.get_next(); next.first != pqxx::array_parser::done;
       next = parser.get_next()) {
    if (next.first == pqxx::array_parser::string_value) texts.push_back(next.second);
  }
  return texts;
}

DataSet read(const pqxx::row& row) {
  DataSet d;
  d.id = row[0].as<std::string>();
  d.title = row[1].as<std::string>();
  d.state = data_set_state_of(row[2].as<std::string>());
  d.owned = row[3].as<bool>();
  d.is_public = row[4].as<bool>();
  d.is_sample = row[5].as<bool>();
  d.refusal_code = row[6].as<std::string>();
  d.refusal_text = row[7].as<std::string>();
  d.modality = row[8].as<std::string>();
  d.size = {row[9].as<int>(), row[10].as<int>(), row[11].as<int>()};
  d.spacing = {row[12].as<double>(), row[13].as<double>(), row[14].as<double>()};
  d.volume_bytes = row[15].as<std::int64_t>();
  d.repairs = read_texts(row[16]);
  d.created_at = from_us(row[17].as<std::int64_t>());
  d.updated_at = from_us(row[18].as<std::int64_t>());
  if (d.owned && d.state == DataSetState::kUploading && !row[19].is_null()) {
    d.upload = Upload{d.id, row[19].as<std::int64_t>(), row[20].as<std::int64_t>(),
                      from_us(row[21].as<std::int64_t>()), d.state};
  }
  return d;
}

void dispose_of(pqxx::work& transaction, const char* kind, const std::string& id, Time now) {
  transaction.exec_params0(R"sql(
      INSERT INTO disposals (kind, id, created_at) VALUES ($1, $2, to_timestamp($3::bigint / 1e6))
      ON CONFLICT DO NOTHING)sql",
                           kind, id, to_us(now));
}

tl::unexpected<Error> not_found() {
  return fail(ErrorCode::kNotFound, "There is no such data set.");
}

}  // namespace

Result<std::variant<Created, OverQuota, KeyReused>> DataSetRepository::create(
    const NewDataSet& data_set, const std::optional<IdempotencyKey>& key, Time now) {
  using Answer = std::variant<Created, OverQuota, KeyReused>;
  return database_.transact([&](pqxx::work& transaction) -> Result<Answer> {
    const std::string& user_id = data_set.owner.user_id;
    const bool sample = user_id.empty();
    if (!sample) {
      // Holds the account, so the same key beside this one waits and then finds what was made.
      const Quota quota = lock_quota(transaction, user_id);
      if (key) {
        const pqxx::result before = transaction.exec_params(
            R"sql(
            SELECT request_hash, created_id FROM idempotency_keys
             WHERE user_id = $1 AND route = $2 AND key = $3)sql",
            user_id, key->route, key->key);
        if (!before.empty()) {
          if (before[0][0].as<std::string>() != key->request_hash) return KeyReused{};
          return Created{before[0][1].as<std::string>(), true};
        }
      }
      if (data_set.bytes > quota.bytes - quota.used) return OverQuota{quota};
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO data_sets (id, owner_id, title, state, is_public, is_sample, created_at, updated_at)
        VALUES ($1, $2, $3, 'uploading', $4, $4,
                to_timestamp($5::bigint / 1e6), to_timestamp($5::bigint / 1e6)))sql",
        data_set.id, owner_or_null(data_set.owner), data_set.title, sample, to_us(now));
    transaction.exec_params0(R"sql(
        INSERT INTO uploads (id, data_set_id, length, expires_at)
        VALUES ($1, $1, $2, to_timestamp($3::bigint / 1e6)))sql",
                             data_set.id, data_set.bytes, to_us(data_set.expires_at));
    if (key) {
      transaction.exec_params0(
          R"sql(
          INSERT INTO idempotency_keys (user_id, route, key, request_hash, created_id, created_at)
          VALUES ($1, $2, $3, $4, $5, to_timestamp($6::bigint / 1e6)))sql",
          user_id, key->route, key->key, key->request_hash, data_set.id, to_us(now));
    }
    return Created{data_set.id, false};
  });
}

Result<std::vector<DataSet>> DataSetRepository::list(const Owner& viewer,
                                                     std::optional<Cursor> after, int limit) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<DataSet>> {
    const pqxx::result rows =
        transaction.exec_params(std::string(kSelect) + R"sql(
           AND ($4::bool OR (d.created_at, d.id) < (to_timestamp($2::bigint / 1e6), $3::uuid))
         ORDER BY d.created_at DESC, d.id DESC LIMIT $5)sql",
                                owner_or_null(viewer), after ? after->created_us : std::int64_t{0},
                                after ? after->id.c_str() : nullptr, !after.has_value(), limit);
    std::vector<DataSet> found;
    for (const pqxx::row& row : rows) found.push_back(read(row));
    return found;
  });
}

Result<DataSet> DataSetRepository::find(const Owner& viewer, const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<DataSet> {
    const pqxx::result rows =
        transaction.exec_params(std::string(kSelect) + " AND d.id = $2", owner_or_null(viewer), id);
    if (rows.empty()) return not_found();
    return read(rows[0]);
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
    dispose_of(transaction, "upload", id, now);
    dispose_of(transaction, "volume", id, now);
    return {};
  });
}

Result<Upload> DataSetRepository::find_upload(const Owner& owner, const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Upload> {
    // An expired one has no row in `uploads` any more, but its owner is told what became of it.
    const pqxx::result rows = transaction.exec_params(R"sql(
        SELECT d.state, COALESCE(u.length, 0), COALESCE(u.received, 0),
               COALESCE((extract(epoch FROM u.expires_at) * 1000000)::bigint, 0)
          FROM data_sets d LEFT JOIN uploads u ON u.data_set_id = d.id
         WHERE d.id = $2 AND (d.owner_id = $1::uuid OR ($1::uuid IS NULL AND d.owner_id IS NULL AND d.is_sample))
           AND (u.id IS NOT NULL OR d.state = 'expired'))sql",
                                                      owner_or_null(owner), id);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "There is no such upload.");
    return Upload{id, rows[0][1].as<std::int64_t>(), rows[0][2].as<std::int64_t>(),
                  from_us(rows[0][3].as<std::int64_t>()),
                  data_set_state_of(rows[0][0].as<std::string>())};
  });
}

Result<void> DataSetRepository::advance_upload(const std::string& id, std::int64_t from,
                                               std::int64_t to, Time expires_at, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result moved = transaction.exec_params(
        R"sql(
        WITH standing AS (SELECT id FROM data_sets WHERE id = $1 AND state = 'uploading' FOR UPDATE)
        UPDATE uploads SET received = $3, expires_at = to_timestamp($4::bigint / 1e6)
          FROM standing
         WHERE uploads.data_set_id = standing.id AND uploads.received = $2
        RETURNING uploads.length)sql",
        id, from, to, to_us(expires_at));
    if (moved.empty()) return fail(ErrorCode::kConflict, "The upload stands elsewhere by now.");
    if (moved[0][0].as<std::int64_t>() != to) return {};
    transaction.exec_params0(R"sql(
        UPDATE data_sets SET state = 'queued', updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1)sql",
                             id, to_us(now));
    transaction.exec_params0("INSERT INTO ingest_jobs (data_set_id, upload_id) VALUES ($1, $1)",
                             id);
    transaction.exec("NOTIFY ingest_jobs");
    return {};
  });
}

Result<void> DataSetRepository::cancel_upload(const Owner& owner, const std::string& id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT state FROM data_sets
         WHERE id = $2 AND (owner_id = $1::uuid OR ($1::uuid IS NULL AND owner_id IS NULL AND is_sample))
           FOR UPDATE)sql",
        owner_or_null(owner), id);
    if (found.empty()) return not_found();
    if (data_set_state_of(found[0][0].as<std::string>()) != DataSetState::kUploading) {
      return fail(ErrorCode::kConflict, "It is past uploading.");
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
         WHERE d.state = 'uploading' AND u.expires_at <= to_timestamp($1::bigint / 1e6)
         ORDER BY u.expires_at LIMIT 100 FOR UPDATE OF d SKIP LOCKED)sql",
        to_us(now));
    for (const pqxx::row& row : late) {
      const auto id = row[0].as<std::string>();
      transaction.exec_params0(R"sql(
          UPDATE data_sets SET state = 'expired', updated_at = to_timestamp($2::bigint / 1e6)
           WHERE id = $1)sql",
                               id, to_us(now));
      transaction.exec_params0("DELETE FROM uploads WHERE id = $1", id);
      dispose_of(transaction, "upload", id, now);
    }
    return static_cast<int>(late.size());
  });
}

Result<std::vector<Disposal>> DataSetRepository::disposals(int limit) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<Disposal>> {
    const pqxx::result rows = transaction.exec_params(
        "SELECT kind, id FROM disposals ORDER BY created_at LIMIT $1", limit);
    std::vector<Disposal> found;
    for (const pqxx::row& row : rows) {
      const bool upload = row[0].as<std::string>() == "upload";
      found.push_back(
          {upload ? Disposal::Kind::kUpload : Disposal::Kind::kVolume, row[1].as<std::string>()});
    }
    return found;
  });
}

Result<void> DataSetRepository::disposed(const Disposal& disposal) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const char* kind = disposal.kind == Disposal::Kind::kUpload ? "upload" : "volume";
    transaction.exec_params0("DELETE FROM disposals WHERE kind = $1 AND id = $2", kind,
                             disposal.id);
    return {};
  });
}

}  // namespace diaphane::api
