#include "api/scans/view_rows.h"

namespace diaphane::api {
namespace {

const char* or_null(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

}  // namespace

void note_views(pqxx::work& transaction, const std::vector<std::string>& data_set_ids,
                const View& view, Time now) {
  std::string ids = "{";
  for (const std::string& id : data_set_ids) ids += (ids.size() > 1 ? "," : "") + id;
  ids += "}";
  const std::string route(to_string(view.route));
  // Concurrent views by one viewer wait here, so that they are counted in one entry.
  transaction.exec_params(
      "SELECT 1 FROM data_sets WHERE id = ANY ($1::uuid[]) ORDER BY id FOR NO KEY UPDATE", ids);
  const pqxx::result added = transaction.exec_params(
      R"sql(
      WITH again AS (
        UPDATE views SET times = times + 1, last_at = to_timestamp($7::bigint / 1e6)
         WHERE data_set_id = ANY ($1::uuid[]) AND route = $2 AND viewer_hash = $3
           AND network = $5 AND browser = $6 AND last_at > to_timestamp($8::bigint / 1e6)
        RETURNING data_set_id)
      INSERT INTO views (id, data_set_id, route, viewer_hash, email_key, link_created_at, network,
                         browser, first_at, last_at)
      SELECT gen_random_uuid(), d.id, $2, $3, p.email_key,
             (SELECT created_at FROM data_set_links WHERE id = $4::uuid), $5, $6, t, t
        FROM data_sets d
        LEFT JOIN data_set_people p
               ON $2 = 'person' AND p.data_set_id = d.id AND p.user_id = $9::uuid
       CROSS JOIN to_timestamp($7::bigint / 1e6) AS t
       WHERE d.id = ANY ($1::uuid[])
         AND d.id NOT IN (SELECT data_set_id FROM again)
      RETURNING data_set_id)sql",
      ids, route, viewer_hash(view.viewer), or_null(view.link_id),
      coarse_network(view.client.address), view.client.browser, to_us(now), to_us(now - kSameView),
      view.by_account() ? view.viewer.c_str() : nullptr);
  if (added.empty()) return;
  transaction.exec_params0(
      R"sql(
      DELETE FROM views WHERE id IN (
        SELECT id FROM (
          SELECT id, row_number() OVER (PARTITION BY data_set_id ORDER BY last_at DESC, id DESC) AS place
            FROM views WHERE data_set_id = ANY ($1::uuid[]) AND route = $2) AS ranked
         WHERE place > $3))sql",
      ids, route, kMostViews);
}

std::vector<ViewEntry> read_views(pqxx::work& transaction, const std::string& data_set_id,
                                  const ViewQuery& query) {
  const auto& after = query.after;
  std::vector<ViewEntry> found;
  for (const pqxx::row& row : transaction.exec_params(
           R"sql(
           SELECT id, route, COALESCE(email_key, '') AS email_key, network, browser, times,
                  (extract(epoch FROM link_created_at) * 1000000)::bigint AS link_created_us,
                  (extract(epoch FROM first_at) * 1000000)::bigint AS first_us,
                  (extract(epoch FROM last_at) * 1000000)::bigint AS last_us
             FROM views
            WHERE data_set_id = $1 AND ($2::bool OR route NOT IN ('owner', 'export'))
              AND ($3::bool OR (last_at, id) < (to_timestamp($4::bigint / 1e6), $5::uuid))
            ORDER BY last_at DESC, id DESC LIMIT $6)sql",
           data_set_id, query.own, !after.has_value(), after ? after->created_us : std::int64_t{0},
           after ? after->id.c_str() : nullptr, query.limit)) {
    ViewEntry& entry = found.emplace_back();
    entry.id = row["id"].as<std::string>();
    entry.route = view_route_of(row["route"].as<std::string>());
    entry.email_key = row["email_key"].as<std::string>();
    if (!row["link_created_us"].is_null()) {
      entry.link_created_at = from_us(row["link_created_us"].as<std::int64_t>());
    }
    entry.network = row["network"].as<std::string>();
    entry.browser = row["browser"].as<std::string>();
    entry.first_at = from_us(row["first_us"].as<std::int64_t>());
    entry.last_at = from_us(row["last_us"].as<std::int64_t>());
    entry.times = row["times"].as<int>();
  }
  return found;
}

void forget_viewer(pqxx::work& transaction, const std::string& user_id) {
  transaction.exec_params0(
      "UPDATE views SET email_key = NULL, viewer_hash = gen_random_uuid()::text "
      "WHERE viewer_hash = $1",
      viewer_hash(user_id));
}

}  // namespace diaphane::api
