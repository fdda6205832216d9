#include "api/presets/preset_repository.h"

#include "api/scans/data_set_rows.h"
#include "api/shared/idempotency_rows.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Error> no_preset() { return fail(ErrorCode::kNotFound, "Preset not found."); }

/// Selects presets for the viewer $1 (or NULL). Queries append large columns, kTables and WHERE.
constexpr const char* kColumns = R"sql(
  SELECT p.id, p.data_set_id, p.author_id, u.public_name, p.name, p.version,
         COALESCE((SELECT sum(value) FROM preset_votes v WHERE v.preset_id = p.id), 0)::int AS votes,
         COALESCE((SELECT value FROM preset_votes v WHERE v.preset_id = p.id AND v.user_id = $1::uuid), 0) AS my_vote,
         d.default_preset_id IS NOT DISTINCT FROM p.id AS is_default,
         d.default_preset_id IS NOT DISTINCT FROM p.id AND d.default_scene IS DISTINCT FROM p.scene
           AS changed_since_default,
         p.author_id IS NOT DISTINCT FROM $1::uuid AS mine,
         (extract(epoch FROM p.created_at) * 1000000)::bigint AS created_us,
         (extract(epoch FROM p.updated_at) * 1000000)::bigint AS updated_us,
         p.taken_down_at IS NOT NULL AS taken_down, COALESCE(p.taken_down_reason, '') AS taken_down_reason,
         (extract(epoch FROM p.pictured_at) * 1000000)::bigint AS pictured_us)sql";
constexpr const char* kTables = R"sql(
    FROM presets p JOIN users u ON u.id = p.author_id JOIN data_sets d ON d.id = p.data_set_id)sql";

Preset read_preset(const pqxx::row& row) {
  Preset preset;
  preset.id = row["id"].as<std::string>();
  preset.data_set_id = row["data_set_id"].as<std::string>();
  preset.author_id = row["author_id"].as<std::string>();
  preset.author_name = shown_name(row["public_name"].as<std::string>());
  preset.name = row["name"].as<std::string>();
  preset.version = row["version"].as<int>();
  preset.votes = row["votes"].as<int>();
  preset.my_vote = row["my_vote"].as<int>();
  preset.is_default = row["is_default"].as<bool>();
  preset.changed_since_default = row["changed_since_default"].as<bool>();
  preset.mine = row["mine"].as<bool>();
  preset.created_at = from_us(row["created_us"].as<std::int64_t>());
  preset.updated_at = from_us(row["updated_us"].as<std::int64_t>());
  preset.taken_down = row["taken_down"].as<bool>();
  preset.taken_down_reason = row["taken_down_reason"].as<std::string>();
  if (!row["pictured_us"].is_null())
    preset.pictured_at = from_us(row["pictured_us"].as<std::int64_t>());
  return preset;
}

const char* id_or_null(const std::string& id) { return id.empty() ? nullptr : id.c_str(); }

/// Explains why a statement had no effect: the preset is gone or has another version.
tl::unexpected<Error> why_not(pqxx::work& transaction, const std::string& id) {
  if (transaction.exec_params("SELECT 1 FROM presets WHERE id = $1", id).empty())
    return no_preset();
  return fail(ErrorCode::kConflict, "The preset has changed in the meantime.");
}

}  // namespace

Result<std::vector<Preset>> PresetRepository::list(const std::string& data_set_id,
                                                   const std::string& viewer_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Preset>> {
    const pqxx::result rows = transaction.exec_params(std::string(kColumns) + kTables + R"sql(
         WHERE p.data_set_id = $2 AND u.disabled_at IS NULL
         ORDER BY is_default DESC, votes DESC, p.created_at, p.id)sql",
                                                      id_or_null(viewer_id), data_set_id);
    std::vector<Preset> found;
    for (const pqxx::row& row : rows) found.push_back(read_preset(row));
    return found;
  });
}

Result<Preset> PresetRepository::find(const std::string& id, const std::string& viewer_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<Preset> {
    const pqxx::result rows =
        transaction.exec_params(std::string(kColumns) +
                                    ", p.scene, COALESCE(p.annotations, '') AS annotations, "
                                    "COALESCE(p.kept_xml, '') AS kept_xml" +
                                    kTables + " WHERE p.id = $2 AND u.disabled_at IS NULL",
                                id_or_null(viewer_id), id);
    if (rows.empty()) return no_preset();
    Preset preset = read_preset(rows[0]);
    preset.scene = rows[0]["scene"].as<std::string>();
    preset.annotations = rows[0]["annotations"].as<std::string>();
    preset.kept_xml = rows[0]["kept_xml"].as<std::string>();
    return preset;
  });
}

Result<std::variant<Created, KeyReused>> PresetRepository::add(
    const Preset& preset, const std::optional<IdempotencyKey>& key, const Limits& limits) {
  using Answer = std::variant<Created, KeyReused>;
  return database_.transact([&](pqxx::work& transaction) -> Result<Answer> {
    if (const auto before = made_before(transaction, preset.author_id, key)) return *before;
    // The lock serialises concurrent additions, so that each is counted.
    if (transaction
            .exec_params("SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", preset.data_set_id)
            .empty()) {
      return no_preset();
    }
    const auto count = transaction.exec_params1(
        "SELECT count(*) FILTER (WHERE author_id = $2) AS of_author, count(*) AS of_data_set FROM "
        "presets "
        "WHERE data_set_id = $1",
        preset.data_set_id, preset.author_id);
    if (count["of_author"].as<int>() >= limits.of_author ||
        count["of_data_set"].as<int>() >= limits.of_data_set) {
      return fail(ErrorCode::kTooMany,
                  "This scan has reached its preset limit. Delete one of your presets first.");
    }
    transaction.exec_params0(R"sql(
        INSERT INTO presets (id, data_set_id, author_id, name, scene, annotations, kept_xml, created_at, updated_at)
        SELECT $1, $2, $3, $4, $5, NULLIF($6, ''), NULLIF($7, ''), t, t FROM to_timestamp($8::bigint / 1e6) AS t)sql",
                             preset.id, preset.data_set_id, preset.author_id, preset.name,
                             preset.scene, preset.annotations, preset.kept_xml,
                             to_us(preset.created_at));
    note_made(transaction, preset.author_id, key, preset.id, preset.created_at);
    return Created{preset.id, false};
  });
}

Result<void> PresetRepository::change(const std::string& id, int version, const PresetChange& what,
                                      Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result changed = transaction.exec_params(
        R"sql(
        UPDATE presets SET name = COALESCE($3, name), scene = COALESCE($4, scene),
                           annotations = NULLIF(COALESCE($6, annotations), ''), version = version + 1, updated_at = to_timestamp($5::bigint / 1e6)
         WHERE id = $1 AND version = $2 RETURNING 1)sql",
        id, version, what.name ? what.name->c_str() : nullptr,
        what.scene ? what.scene->c_str() : nullptr, to_us(now), what.annotations);
    if (changed.empty()) return why_not(transaction, id);
    // The default follows changes of the owner's own preset. Of another author's, it stays a copy.
    transaction.exec_params0(R"sql(
        UPDATE data_sets d SET default_scene = p.scene
          FROM presets p
         WHERE p.id = $1 AND d.default_preset_id = p.id AND d.owner_id = p.author_id)sql",
                             id);
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
    if (noted.empty()) return no_preset();
    return {};
  });
}

Result<void> PresetRepository::set_default(const std::string& data_set_id,
                                           const std::string& preset_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result done = transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET default_preset_id = $2::uuid,
               default_scene = (SELECT scene FROM presets WHERE id = $2::uuid)
         WHERE id = $1 AND ($2::uuid IS NULL OR EXISTS (
               SELECT 1 FROM presets
                WHERE id = $2::uuid AND data_set_id = $1 AND taken_down_at IS NULL))
        RETURNING 1)sql",
        data_set_id, id_or_null(preset_id));
    if (done.empty()) return no_preset();
    return {};
  });
}

Result<std::string> PresetRepository::default_scene(const std::string& data_set_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::string> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT d.default_scene FROM data_sets d JOIN presets p ON p.id = d.default_preset_id
         WHERE d.id = $1 AND p.taken_down_at IS NULL)sql",
        data_set_id);
    if (rows.empty()) return std::string();
    return rows[0]["default_scene"].as<std::string>();
  });
}

Result<std::optional<PresetPicture>> PresetRepository::claim_picture(Time now,
                                                                     std::chrono::seconds lease) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::optional<PresetPicture>> {
    // A pending deletion runs first, because it would remove the new file as well.
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        WITH next AS (
          SELECT p.id, d.anonymised_at FROM presets p JOIN data_sets d ON d.id = p.data_set_id
           WHERE p.pictured_at IS NULL AND p.picture_not_before <= to_timestamp($1::bigint / 1e6)
             AND d.state = 'ready'
             AND NOT EXISTS (SELECT 1 FROM disposals g WHERE g.kind = 'preset' AND g.id = p.id)
           ORDER BY p.picture_not_before, p.created_at, p.id LIMIT 1 FOR UPDATE OF p SKIP LOCKED)
        UPDATE presets p
           SET picture_tries = p.picture_tries + 1,
               picture_not_before = to_timestamp($1::bigint / 1e6)
                 + make_interval(secs => $2 * (1 << least(p.picture_tries, 6)))
          FROM next WHERE p.id = next.id
        RETURNING p.id, p.data_set_id, p.scene,
                  (extract(epoch FROM next.anonymised_at) * 1000000)::bigint AS anonymised_us)sql",
        to_us(now), static_cast<int>(lease.count()));
    if (rows.empty()) return std::nullopt;
    const pqxx::row row = rows[0];
    PresetPicture picture{row["id"].as<std::string>(),
                          row["data_set_id"].as<std::string>(),
                          row["scene"].as<std::string>(),
                          {}};
    if (!row["anonymised_us"].is_null())
      picture.cut_at = from_us(row["anonymised_us"].as<std::int64_t>());
    return picture;
  });
}

Result<void> PresetRepository::postpone_picture(const std::string& preset_id, Time again) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        R"sql(
        UPDATE presets SET picture_not_before = to_timestamp($2::bigint / 1e6),
                           picture_tries = greatest(picture_tries - 1, 0)
         WHERE id = $1 AND pictured_at IS NULL)sql",
        preset_id, to_us(again));
    return {};
  });
}

Result<bool> PresetRepository::keep_picture(const PresetPicture& picture, Time now,
                                            const std::function<Result<void>()>& write) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    // The lock is held until the file exists, so that later changes, anonymisations and deletions
    // remove it.
    const pqxx::result same = transaction.exec_params(
        R"sql(
        SELECT 1 FROM presets p JOIN data_sets d ON d.id = p.data_set_id
         WHERE p.id = $1 AND p.scene = $2 AND d.state = 'ready'
           AND COALESCE((extract(epoch FROM d.anonymised_at) * 1000000)::bigint, 0) = $3
           AND NOT EXISTS (SELECT 1 FROM disposals g WHERE g.kind = 'preset' AND g.id = p.id)
           FOR UPDATE OF p)sql",
        picture.preset_id, picture.scene, picture.cut_at ? to_us(*picture.cut_at) : 0);
    if (same.empty()) return false;
    DIAPHANE_TRY(write());
    transaction.exec_params0(
        "UPDATE presets SET pictured_at = to_timestamp($2::bigint / 1e6) WHERE id = $1",
        picture.preset_id, to_us(now));
    return true;
  });
}

Result<void> PresetRepository::forget_picture(const std::string& preset_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("UPDATE presets SET pictured_at = NULL WHERE id = $1", preset_id);
    return {};
  });
}

}  // namespace diaphane::api
