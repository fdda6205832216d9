#include "api/postgres/preset_repository.h"

namespace diaphane::api {
namespace {

tl::unexpected<Error> none() { return fail(ErrorCode::kNotFound, "There is no such preset."); }

/// $1 is the viewer, or NULL. What follows FROM and the large columns differ.
constexpr const char* kColumns = R"sql(
  SELECT p.id, p.data_set_id, p.author_id, u.public_name, p.name, p.version,
         COALESCE((SELECT sum(value) FROM preset_votes v WHERE v.preset_id = p.id), 0)::int AS votes,
         COALESCE((SELECT value FROM preset_votes v WHERE v.preset_id = p.id AND v.user_id = $1::uuid), 0),
         d.default_preset_id IS NOT DISTINCT FROM p.id AS is_default,
         p.author_id IS NOT DISTINCT FROM $1::uuid,
         (extract(epoch FROM p.created_at) * 1000000)::bigint,
         (extract(epoch FROM p.updated_at) * 1000000)::bigint)sql";
constexpr const char* kTables = R"sql(
    FROM presets p JOIN users u ON u.id = p.author_id JOIN data_sets d ON d.id = p.data_set_id)sql";

Preset read(const pqxx::row& row) {
  Preset preset;
  preset.id = row[0].as<std::string>();
  preset.data_set_id = row[1].as<std::string>();
  preset.author_id = row[2].as<std::string>();
  preset.author_name = row[3].as<std::string>();
  preset.name = row[4].as<std::string>();
  preset.version = row[5].as<int>();
  preset.votes = row[6].as<int>();
  preset.my_vote = row[7].as<int>();
  preset.is_default = row[8].as<bool>();
  preset.mine = row[9].as<bool>();
  preset.created_at = from_us(row[10].as<std::int64_t>());
  preset.updated_at = from_us(row[11].as<std::int64_t>());
  return preset;
}

const char* id_or_null(const std::string& id) { return id.empty() ? nullptr : id.c_str(); }

/// After a statement that changed nothing: was it gone, or of another version?
tl::unexpected<Error> why_not(pqxx::work& transaction, const std::string& id) {
  if (transaction.exec_params("SELECT 1 FROM presets WHERE id = $1", id).empty()) return none();
  return fail(ErrorCode::kConflict, "It is of another version by now.");
}

}  // namespace

Result<std::vector<Preset>> PresetRepository::list(const std::string& data_set_id,
                                                   const std::string& viewer_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<Preset>> {
    const pqxx::result rows = transaction.exec_params(std::string(kColumns) + kTables + R"sql(
         WHERE p.data_set_id = $2
         ORDER BY is_default DESC, votes DESC, p.created_at, p.id)sql",
                                                      id_or_null(viewer_id), data_set_id);
    std::vector<Preset> found;
    for (const pqxx::row& row : rows) found.push_back(read(row));
    return found;
  });
}

Result<Preset> PresetRepository::find(const std::string& id, const std::string& viewer_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Preset> {
    const pqxx::result rows =
        transaction.exec_params(std::string(kColumns) + ", p.scene, COALESCE(p.kept_xml, '')" +
                                    kTables + " WHERE p.id = $2",
                                id_or_null(viewer_id), id);
    if (rows.empty()) return none();
    Preset preset = read(rows[0]);
    preset.scene = rows[0][12].as<std::string>();
    preset.kept_xml = rows[0][13].as<std::string>();
    return preset;
  });
}

Result<void> PresetRepository::add(const Preset& preset, const Limits& limits) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // Additions at once are counted one after the other.
    if (transaction
            .exec_params("SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", preset.data_set_id)
            .empty()) {
      return none();
    }
    const auto count = transaction.exec_params1(
        "SELECT count(*) FILTER (WHERE author_id = $2), count(*) FROM presets "
        "WHERE data_set_id = $1",
        preset.data_set_id, preset.author_id);
    if (count[0].as<int>() >= limits.of_author || count[1].as<int>() >= limits.of_data_set) {
      return fail(ErrorCode::kTooMany,
                  "This scan has as many presets as it may have; delete one of yours first.");
    }
    transaction.exec_params0(R"sql(
        INSERT INTO presets (id, data_set_id, author_id, name, scene, kept_xml, created_at, updated_at)
        SELECT $1, $2, $3, $4, $5, NULLIF($6, ''), t, t FROM to_timestamp($7::bigint / 1e6) AS t)sql",
                             preset.id, preset.data_set_id, preset.author_id, preset.name,
                             preset.scene, preset.kept_xml, to_us(preset.created_at));
    return {};
  });
}

Result<void> PresetRepository::change(const std::string& id, int version, const PresetChange& what,
                                      Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result changed = transaction.exec_params(
        R"sql(
        UPDATE presets SET name = COALESCE($3, name), scene = COALESCE($4, scene),
                           version = version + 1, updated_at = to_timestamp($5::bigint / 1e6)
         WHERE id = $1 AND version = $2 RETURNING 1)sql",
        id, version, what.name ? what.name->c_str() : nullptr,
        what.scene ? what.scene->c_str() : nullptr, to_us(now));
    if (changed.empty()) return why_not(transaction, id);
    return {};
  });
}

Result<void> PresetRepository::remove(const std::string& id, int version) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result gone = transaction.exec_params(
        "DELETE FROM presets WHERE id = $1 AND version = $2 RETURNING 1", id, version);
    if (gone.empty()) return why_not(transaction, id);
    return {};
  });
}

Result<void> PresetRepository::vote(const std::string& id, const std::string& user_id, int value) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    if (value == 0) {
      transaction.exec_params0("DELETE FROM preset_votes WHERE preset_id = $1 AND user_id = $2", id,
                               user_id);
      return {};
    }
    const pqxx::result noted = transaction.exec_params(
        R"sql(
        INSERT INTO preset_votes (preset_id, user_id, value)
        SELECT id, $2, $3 FROM presets WHERE id = $1
        ON CONFLICT (preset_id, user_id) DO UPDATE SET value = excluded.value RETURNING 1)sql",
        id, user_id, value);
    if (noted.empty()) return none();
    return {};
  });
}

Result<void> PresetRepository::set_default(const std::string& data_set_id,
                                           const std::string& preset_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result done = transaction.exec_params(
        R"sql(
        UPDATE data_sets SET default_preset_id = $2::uuid
         WHERE id = $1 AND ($2::uuid IS NULL OR EXISTS (
               SELECT 1 FROM presets WHERE id = $2::uuid AND data_set_id = $1))
        RETURNING 1)sql",
        data_set_id, id_or_null(preset_id));
    if (done.empty()) return none();
    return {};
  });
}

}  // namespace diaphane::api
