#include "api/sharing/sharing_repository.h"

#include "api/accounts/account_repository.h"
#include "api/scans/data_set_rows.h"
#include "api/shared/audit_repository.h"
#include "api/shared/idempotency_rows.h"

namespace diaphane::api {
namespace {

/// Locks a data set, so that concurrent additions are serialised and each is counted. Returns false
/// if the data set no longer exists.
bool lock_data_set(pqxx::work& transaction, const std::string& id) {
  return !transaction.exec_params("SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", id).empty();
}

/// Adds an audit entry. Its actor is the owner, because only owners change access (access.h).
void note_change_of_access(pqxx::work& transaction, const std::string& data_set_id,
                           const std::string& action, const std::vector<AuditDetail>& details,
                           Time now) {
  const auto owner =
      transaction.exec_params("SELECT owner_id FROM data_sets WHERE id = $1", data_set_id);
  if (owner.empty() || owner[0]["owner_id"].is_null()) return;
  note_in_audit_log(transaction,
                    {AuditActor::kPerson, owner[0]["owner_id"].as<std::string>(), action,
                     "data_set", data_set_id, details},
                    now);
}

/// Adds the permissions to the details of an audit entry as numbers, 1 for allowed.
std::vector<AuditDetail> with_permissions(std::vector<AuditDetail> details,
                                          const Permissions& allowed) {
  details.emplace_back("slices", std::int64_t{allowed.slices});
  details.emplace_back("downloads", std::int64_t{allowed.downloads});
  return details;
}

Permissions permissions_in(const pqxx::row& row) {
  return {row["slices"].as<bool>(), row["downloads"].as<bool>()};
}

DataSetLink link_in(const pqxx::row& row) {
  return {row["id"].as<std::string>(), from_us(row["created_us"].as<std::int64_t>()),
          from_us(row["expires_us"].as<std::int64_t>()), permissions_in(row)};
}

/// Changes what a person may do, and records that in the audit log. `person` is the ID of the
/// permission or the key of the address. Returns nothing if the data set is not shared with them.
std::optional<SharingStore::Shared> change_in(pqxx::work& transaction,
                                              const std::string& data_set_id,
                                              const std::string& person, const PersonChange& change,
                                              Time now) {
  const pqxx::result rows = transaction.exec_params(
      R"sql(
      WITH old AS (SELECT id, slices, downloads FROM data_set_people
                    WHERE data_set_id = $1 AND (id::text = $2 OR email_key = $2) FOR UPDATE)
      UPDATE data_set_people p
         SET may_save = COALESCE($3::bool, p.may_save), slices = COALESCE($4::bool, p.slices),
             downloads = COALESCE($5::bool, p.downloads)
        FROM old WHERE p.id = old.id
      RETURNING p.id, COALESCE(p.user_id::text, '') AS user_id, p.may_save, p.slices, p.downloads,
                (old.slices AND NOT p.slices) OR (old.downloads AND NOT p.downloads) AS narrowed)sql",
      data_set_id, person, change.may_save, change.slices, change.downloads);
  if (rows.empty()) return std::nullopt;
  const pqxx::row row = rows[0];
  note_change_of_access(transaction, data_set_id, "data-set.shared",
                        with_permissions({{"permission", row["id"].as<std::string>()},
                                          {"may", row["may_save"].as<bool>() ? "save" : "view"}},
                                         permissions_in(row)),
                        now);
  SharingStore::Shared changed;
  if (row["narrowed"].as<bool>()) changed.narrowed_user_id = row["user_id"].as<std::string>();
  return changed;
}

}  // namespace

Result<std::vector<SharedPerson>> SharingRepository::people(const std::string& data_set_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<SharedPerson>> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT id, email_key, may_save, slices, downloads,
               (extract(epoch FROM created_at) * 1000000)::bigint AS created_us
          FROM data_set_people WHERE data_set_id = $1 ORDER BY created_at, email_key)sql",
        data_set_id);
    std::vector<SharedPerson> found;
    for (const pqxx::row& row : rows) {
      found.push_back({row["id"].as<std::string>(), row["email_key"].as<std::string>(),
                       row["may_save"].as<bool>(), permissions_in(row),
                       from_us(row["created_us"].as<std::int64_t>())});
    }
    return found;
  });
}

Result<SharingStore::Shared> SharingRepository::share_with(const std::string& data_set_id,
                                                           const SharedPerson& person, int most,
                                                           const Mail& mail) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Shared> {
    if (!lock_data_set(transaction, data_set_id))
      return fail(ErrorCode::kNotFound, "Scan not found.");
    const PersonChange change{person.may_save, person.allowed.slices, person.allowed.downloads};
    if (auto known =
            change_in(transaction, data_set_id, person.email_key, change, person.created_at)) {
      return *std::move(known);
    }
    const auto count = transaction.exec_params1(
        "SELECT count(*) AS people FROM data_set_people WHERE data_set_id = $1", data_set_id);
    if (count["people"].as<int>() >= most) {
      return fail(ErrorCode::kTooMany,
                  "You have reached the maximum number of people for this scan.");
    }
    transaction.exec_params0(R"sql(
        INSERT INTO data_set_people (id, data_set_id, email_key, may_save, created_at, slices, downloads)
        VALUES ($1, $2, $3, $4, to_timestamp($5::bigint / 1e6), $6, $7))sql",
                             person.id, data_set_id, person.email_key, person.may_save,
                             to_us(person.created_at), person.allowed.slices,
                             person.allowed.downloads);
    // Grants access at once if the address has a confirmed account.
    const pqxx::result existing =
        transaction.exec_params("SELECT id FROM users WHERE email_key = $1", person.email_key);
    if (!existing.empty()) accept_invitations(transaction, existing[0]["id"].as<std::string>());
    queue_mail(transaction, mail, person.created_at);
    note_change_of_access(
        transaction, data_set_id, "data-set.shared",
        with_permissions({{"permission", person.id}, {"may", person.may_save ? "save" : "view"}},
                         person.allowed),
        person.created_at);
    return Shared{true, {}};
  });
}

Result<SharingStore::Shared> SharingRepository::change_person(const std::string& data_set_id,
                                                              const std::string& person_id,
                                                              const PersonChange& change,
                                                              Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Shared> {
    auto changed = change_in(transaction, data_set_id, person_id, change, now);
    if (!changed) return fail(ErrorCode::kNotFound, "This scan is not shared with this person.");
    return *std::move(changed);
  });
}

Result<std::string> SharingRepository::unshare(const std::string& data_set_id,
                                               const std::string& person_id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::string> {
    const pqxx::result gone = transaction.exec_params(
        R"sql(
        DELETE FROM data_set_people WHERE data_set_id = $1 AND id = $2
        RETURNING COALESCE(user_id::text, '') AS user_id)sql",
        data_set_id, person_id);
    if (gone.empty())
      return fail(ErrorCode::kNotFound, "This scan is not shared with this person.");
    note_change_of_access(transaction, data_set_id, "data-set.unshared",
                          {{"permission", person_id}}, now);
    return gone[0]["user_id"].as<std::string>();
  });
}

Result<std::vector<DataSetLink>> SharingRepository::links(const std::string& data_set_id,
                                                          Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<DataSetLink>> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT id, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us, slices, downloads
          FROM data_set_links WHERE data_set_id = $1 AND expires_at > to_timestamp($2::bigint / 1e6)
         ORDER BY created_at, id)sql",
        data_set_id, to_us(now));
    std::vector<DataSetLink> found;
    for (const pqxx::row& row : rows) found.push_back(link_in(row));
    return found;
  });
}

Result<std::variant<DataSetLink, KeyReused>> SharingRepository::make_link(
    const std::string& data_set_id, const DataSetLink& link, const std::string& token_hash,
    int most, const std::string& owner_id, const std::optional<IdempotencyKey>& key) {
  using Answer = std::variant<DataSetLink, KeyReused>;
  return database_.transact([&](pqxx::work& transaction) -> Result<Answer> {
    if (const auto before = made_before(transaction, owner_id, key)) {
      if (std::holds_alternative<KeyReused>(*before)) return KeyReused{};
      const pqxx::result existing = transaction.exec_params(
          R"sql(
          SELECT id, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
                 (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us, slices, downloads
            FROM data_set_links WHERE id = $1 AND token_hash = $2)sql",
          std::get<Created>(*before).id, token_hash);
      if (existing.empty()) return fail(ErrorCode::kConflict, "The link can't be shown again.");
      return link_in(existing[0]);
    }
    if (!lock_data_set(transaction, data_set_id))
      return fail(ErrorCode::kNotFound, "Scan not found.");
    const auto count = transaction.exec_params1(
        R"sql(SELECT count(*) AS links FROM data_set_links
               WHERE data_set_id = $1 AND expires_at > to_timestamp($2::bigint / 1e6))sql",
        data_set_id, to_us(link.created_at));
    if (count["links"].as<int>() >= most) {
      return fail(ErrorCode::kTooMany,
                  "This scan has reached its link limit. Disable a link first.");
    }
    // A key whose record has expired still derives the token of its link, which may still exist.
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO data_set_links (id, data_set_id, token_hash, created_at, expires_at, slices, downloads)
        VALUES ($1, $2, $3, to_timestamp($4::bigint / 1e6), to_timestamp($5::bigint / 1e6), $6, $7)
        ON CONFLICT (token_hash) DO NOTHING RETURNING 1)sql",
        link.id, data_set_id, token_hash, to_us(link.created_at), to_us(link.expires_at),
        link.allowed.slices, link.allowed.downloads);
    if (made.empty()) return fail(ErrorCode::kConflict, "The link can't be created again.");
    note_made(transaction, owner_id, key, link.id, link.created_at);
    note_change_of_access(transaction, data_set_id, "data-set.link-made",
                          with_permissions({{"link", link.id}}, link.allowed), link.created_at);
    return link;
  });
}

Result<void> SharingRepository::end_link(const std::string& data_set_id, const std::string& link_id,
                                         Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result gone = transaction.exec_params(
        "DELETE FROM data_set_links WHERE data_set_id = $1 AND id = $2 RETURNING 1", data_set_id,
        link_id);
    if (gone.empty()) return fail(ErrorCode::kNotFound, "Link not found.");
    note_change_of_access(transaction, data_set_id, "data-set.link-ended", {{"link", link_id}},
                          now);
    return {};
  });
}

Result<SharingStore::Followed> SharingRepository::follow(const std::string& token_hash, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Followed> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT l.id, (extract(epoch FROM l.created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM l.expires_at) * 1000000)::bigint AS expires_us, d.id AS data_set_id, d.owner_id, l.slices,
               l.downloads
          FROM data_set_links l JOIN data_sets d ON d.id = l.data_set_id
         WHERE l.token_hash = $1 AND l.expires_at > to_timestamp($2::bigint / 1e6)
           AND d.state = 'ready' AND d.taken_down_at IS NULL)sql",
        token_hash, to_us(now));
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Link not found.");
    const pqxx::result data_set = transaction.exec_params(
        std::string(kSelectDataSet) + " AND d.id = $4", rows[0]["owner_id"].c_str(), false, false,
        rows[0]["data_set_id"].as<std::string>());
    if (data_set.empty()) return fail(ErrorCode::kNotFound, "Link not found.");
    Followed followed{link_in(rows[0]), read_data_set(data_set[0])};
    followed.data_set.role = Role::kSharedView;
    return followed;
  });
}

Result<bool> SharingRepository::publish(const std::string& data_set_id, const Permissions& allowed,
                                        Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result done = transaction.exec_params(
        R"sql(
        UPDATE data_sets
           SET visibility = 'public', published_at = COALESCE(published_at, to_timestamp($2::bigint / 1e6)),
               updated_at = to_timestamp($2::bigint / 1e6), public_slices = $3, public_downloads = $4
         WHERE id = $1 AND state = 'ready' AND anonymised_at IS NOT NULL AND taken_down_at IS NULL
        RETURNING 1)sql",
        data_set_id, to_us(now), allowed.slices, allowed.downloads);
    if (done.empty()) return false;
    note_change_of_access(transaction, data_set_id, "data-set.published",
                          with_permissions({}, allowed), now);
    return true;
  });
}

Result<void> SharingRepository::make_private(const std::string& data_set_id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result done = transaction.exec_params(
        R"sql(
        UPDATE data_sets SET visibility = 'private', published_at = NULL, public_slices = false,
                             public_downloads = false,
                             updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1 AND NOT is_sample AND visibility = 'public'
        RETURNING 1)sql",
        data_set_id, to_us(now));
    if (!done.empty()) {
      note_change_of_access(transaction, data_set_id, "data-set.withdrawn", {}, now);
    }
    return {};
  });
}

Result<std::vector<DataSet>> SharingRepository::gallery(const Viewer& viewer,
                                                        const GalleryQuery& query) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<DataSet>> {
    const auto& after = query.after;
    // Each word is a prefix. Spaces and punctuation separate words, so none can be an operator.
    const pqxx::result rows = transaction.exec_params(
        std::string(kSelectDataSet) + R"sql(
           AND d.visibility = 'public' AND d.state = 'ready' AND ($4::bool IS FALSE OR d.is_sample)
           AND ($5 = '' OR d.words @@
                (SELECT to_tsquery('simple', string_agg(quote_literal(word) || ':*', ' & '))
                   FROM regexp_split_to_table($5, '[[:space:][:punct:]]+') AS word WHERE word <> ''))
           AND ($6 = '' OR d.body_part = $6) AND ($7 = '' OR d.modality = $7)
           AND ($8::bool OR (d.published_at, d.id) < (to_timestamp($9::bigint / 1e6), $10::uuid))
         ORDER BY d.published_at DESC, d.id DESC LIMIT $11)sql",
        viewer_or_null(viewer), viewer.sample_operator, viewer.administrator, query.samples_only,
        query.words, query.body_part, query.modality, !after.has_value(),
        after ? after->created_us : std::int64_t{0}, after ? after->id.c_str() : nullptr,
        query.limit);
    std::vector<DataSet> found;
    for (const pqxx::row& row : rows) found.push_back(read_data_set(row));
    return found;
  });
}

Result<std::string> SharingRepository::public_name(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::string> {
    const pqxx::result rows =
        transaction.exec_params("SELECT public_name FROM users WHERE id = $1", user_id);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Account not found.");
    return shown_name(rows[0]["public_name"].as<std::string>());
  });
}

Result<void> SharingRepository::set_public_name(const std::string& user_id,
                                                const std::string& name) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("UPDATE users SET public_name = $2 WHERE id = $1", user_id, name);
    return {};
  });
}

Result<Visit> SharingRepository::note_visit(const Visit& visit, const VisitLimits& limits,
                                            Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Visit> {
    // Serialises the counting, so that the limit also holds for concurrent visitors.
    transaction.exec("LOCK TABLE visits IN SHARE ROW EXCLUSIVE MODE");
    const pqxx::result known = transaction.exec_params(
        R"sql(SELECT (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us FROM visits
               WHERE session_id = $1 AND expires_at > to_timestamp($2::bigint / 1e6))sql",
        visit.session_id, to_us(now));
    Visit noted = visit;
    if (!known.empty()) {
      noted.expires_at = from_us(known[0]["expires_us"].as<std::int64_t>());
      return noted;
    }
    const auto count = transaction.exec_params1(
        R"sql(
        SELECT count(*) AS visits, count(*) FILTER (WHERE address_hash = $2) AS by_address,
               count(*) FILTER (WHERE link_id = $3::uuid) AS by_link
          FROM visits WHERE expires_at > to_timestamp($1::bigint / 1e6))sql",
        to_us(now), visit.address_hash, visit.link_id.empty() ? nullptr : visit.link_id.c_str());
    if (count["visits"].as<int>() >= limits.most) {
      return fail(ErrorCode::kTooMany, "The limit of visits is reached.");
    }
    if (count["by_address"].as<int>() >= limits.by_address) {
      return fail(ErrorCode::kTooMany, "The limit of visits per address is reached.", "address");
    }
    if (count["by_link"].as<int>() >= limits.by_link) {
      return fail(ErrorCode::kTooMany, "The limit of visits per link is reached.", "link");
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO visits (session_id, data_set_id, link_id, expires_at, address_hash)
        SELECT $1, d.id, $3::uuid, to_timestamp($4::bigint / 1e6), $5 FROM data_sets d
         WHERE d.id = $2 AND ($3::uuid IS NULL OR EXISTS (SELECT 1 FROM data_set_links WHERE id = $3::uuid))
        ON CONFLICT (session_id) DO UPDATE SET expires_at = excluded.expires_at)sql",
        visit.session_id, visit.data_set_id,
        visit.link_id.empty() ? nullptr : visit.link_id.c_str(), to_us(visit.expires_at),
        visit.address_hash);
    return noted;
  });
}

Result<Visit> SharingRepository::find_visit(const std::string& session_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<Visit> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT v.data_set_id, COALESCE(v.link_id::text, '') AS link_id,
               (extract(epoch FROM v.expires_at) * 1000000)::bigint AS expires_us
          FROM visits v JOIN data_sets d ON d.id = v.data_set_id
          LEFT JOIN users o ON o.id = d.owner_id
         WHERE v.session_id = $1 AND v.expires_at > to_timestamp($2::bigint / 1e6)
           AND d.taken_down_at IS NULL AND o.disabled_at IS NULL)sql",
        session_id, to_us(now));
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Visit not found.");
    return Visit{session_id, rows[0]["data_set_id"].as<std::string>(),
                 rows[0]["link_id"].as<std::string>(),
                 from_us(rows[0]["expires_us"].as<std::int64_t>())};
  });
}

Result<std::vector<std::string>> SharingRepository::expired_visits(Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> over;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT session_id FROM visits WHERE expires_at <= to_timestamp($1::bigint / 1e6)",
             to_us(now))) {
      over.push_back(row["session_id"].as<std::string>());
    }
    return over;
  });
}

Result<void> SharingRepository::forget_visit(const std::string& session_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("DELETE FROM visits WHERE session_id = $1", session_id);
    return {};
  });
}

Result<void> SharingRepository::expire_links(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // Links with visits are removed later, after their sessions have ended.
    transaction.exec_params0(R"sql(
        DELETE FROM data_set_links l
         WHERE expires_at <= to_timestamp($1::bigint / 1e6)
           AND NOT EXISTS (SELECT 1 FROM visits v WHERE v.link_id = l.id))sql",
                             to_us(now));
    return {};
  });
}

}  // namespace diaphane::api
