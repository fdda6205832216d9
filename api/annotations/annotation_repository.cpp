#include "api/annotations/annotation_repository.h"

namespace diaphane::api {
namespace {

tl::unexpected<Error> no_set() { return fail(ErrorCode::kNotFound, "Marks not found."); }

AnnotationSet read_set(const pqxx::row& row) {
  AnnotationSet set;
  set.id = row["id"].as<std::string>();
  set.data_set_id = row["data_set_id"].as<std::string>();
  set.author_id = row["author_id"].as<std::string>();
  set.name = row["name"].as<std::string>();
  set.content = row["content"].as<std::string>();
  set.shown = row["shown"].as<bool>();
  set.shared = row["shared"].as<bool>();
  set.mine = row["mine"].as<bool>();
  set.created_at = from_us(row["created_us"].as<std::int64_t>());
  set.updated_at = from_us(row["updated_us"].as<std::int64_t>());
  return set;
}

}  // namespace

Result<std::vector<AnnotationSet>> AnnotationRepository::list(const std::string& data_set_id,
                                                              const std::string& viewer_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<AnnotationSet>> {
    std::vector<AnnotationSet> found;
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT a.id, a.data_set_id, a.author_id, a.name, a.content, a.shown, a.shared,
                    a.author_id IS NOT DISTINCT FROM $2::uuid AS mine,
                    (extract(epoch FROM a.created_at) * 1000000)::bigint AS created_us,
                    (extract(epoch FROM a.updated_at) * 1000000)::bigint AS updated_us
               FROM annotations a JOIN users u ON u.id = a.author_id
              WHERE a.data_set_id = $1 AND u.disabled_at IS NULL
                AND (a.shared OR a.author_id = $2::uuid)
              ORDER BY a.created_at, a.id)sql",
             data_set_id, viewer_id.empty() ? nullptr : viewer_id.c_str())) {
      found.push_back(read_set(row));
    }
    return found;
  });
}

Result<void> AnnotationRepository::add(const AnnotationSet& set, int most) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // The lock serialises concurrent additions, so that each is counted.
    if (transaction.exec_params("SELECT 1 FROM data_sets WHERE id = $1 FOR UPDATE", set.data_set_id)
            .empty()) {
      return no_set();
    }
    const auto count = transaction.exec_params1(
        "SELECT count(*)::int AS number FROM annotations WHERE data_set_id = $1 AND author_id = $2",
        set.data_set_id, set.author_id);
    if (count["number"].as<int>() >= most) {
      return fail(ErrorCode::kTooMany, "You have saved " + std::to_string(most) +
                                           " sets of marks for this scan. Delete one of them "
                                           "first.");
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO annotations (id, data_set_id, author_id, name, content, shown, shared, created_at, updated_at)
        SELECT $1, $2, $3, $4, $5, $6, $7, t, t FROM to_timestamp($8::bigint / 1e6) AS t)sql",
        set.id, set.data_set_id, set.author_id, set.name, set.content, set.shown, set.shared,
        to_us(set.created_at));
    return {};
  });
}

Result<void> AnnotationRepository::change(const AnnotationSet& set, const AnnotationChange& what,
                                          Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        R"sql(
        UPDATE annotations SET name = COALESCE($3, name), content = COALESCE($4, content),
                               shown = COALESCE($5, shown), shared = COALESCE($6, shared),
                               updated_at = to_timestamp($7::bigint / 1e6)
         WHERE id = $1 AND author_id = $2 AND ($8::text IS NULL OR content = $8))sql",
        set.id, set.author_id, what.name, what.content, what.shown, what.shared, to_us(now),
        what.revision ? set.content.c_str() : nullptr);
    if (done.affected_rows() == 0) {
      if (what.revision) return fail(ErrorCode::kConflict, "The marks have changed.");
      return no_set();
    }
    return {};
  });
}

Result<void> AnnotationRepository::remove(const AnnotationSet& set) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "DELETE FROM annotations WHERE id = $1 AND author_id = $2", set.id, set.author_id);
    if (done.affected_rows() == 0) return no_set();
    return {};
  });
}

}  // namespace diaphane::api
