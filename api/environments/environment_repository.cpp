#include "api/environments/environment_repository.h"

namespace diaphane::api {
namespace {

constexpr const char* kEnvironmentColumns = R"sql(
  SELECT id, owner_id, name, content, preview, bytes,
         (extract(epoch FROM created_at) * 1000000)::bigint AS created_us
    FROM environments)sql";

Environment read_environment(const pqxx::row& row) {
  Environment environment;
  environment.id = row["id"].as<std::string>();
  environment.owner_id = row["owner_id"].as<std::string>();
  environment.name = row["name"].as<std::string>();
  environment.content_hash = row["content"].as<std::string>();
  environment.preview = row["preview"].as<std::string>();
  environment.bytes = row["bytes"].as<std::int64_t>();
  environment.created_at = from_us(row["created_us"].as<std::int64_t>());
  return environment;
}

tl::unexpected<Error> no_environment() {
  return fail(ErrorCode::kNotFound, "Environment not found.");
}

}  // namespace

Result<std::vector<Environment>> EnvironmentRepository::of(const std::string& owner_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Environment>> {
    std::vector<Environment> found;
    for (const pqxx::row& row :
         transaction.exec_params(std::string(kEnvironmentColumns) +
                                     " WHERE owner_id = $1::uuid ORDER BY created_at DESC, id",
                                 owner_id)) {
      found.push_back(read_environment(row));
    }
    return found;
  });
}

Result<Environment> EnvironmentRepository::find(const std::string& id) {
  return database_.read([&](pqxx::work& transaction) -> Result<Environment> {
    const auto rows =
        transaction.exec_params(std::string(kEnvironmentColumns) + " WHERE id = $1::uuid", id);
    if (rows.empty()) return no_environment();
    return read_environment(rows[0]);
  });
}

Result<void> EnvironmentRepository::add(const Environment& environment, int most) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // The lock serialises concurrent additions, so that each is counted.
    if (transaction
            .exec_params("SELECT 1 FROM users WHERE id = $1::uuid FOR UPDATE", environment.owner_id)
            .empty()) {
      return no_environment();
    }
    const auto row = transaction.exec_params1(
        "SELECT count(*)::int AS number, count(*) FILTER (WHERE content = $2)::int AS same "
        "FROM environments WHERE owner_id = $1::uuid",
        environment.owner_id, environment.content_hash);
    if (row["same"].as<int>() > 0) {
      return fail(ErrorCode::kConflict, "This environment has just been added.");
    }
    if (row["number"].as<int>() >= most) {
      return fail(ErrorCode::kTooMany, "Too many environments.");
    }
    transaction.exec_params0(R"sql(
        INSERT INTO environments (id, owner_id, name, content, preview, bytes, created_at)
        VALUES ($1::uuid, $2::uuid, $3, $4, $5, $6, to_timestamp($7::bigint / 1e6)))sql",
                             environment.id, environment.owner_id, environment.name,
                             environment.content_hash, environment.preview, environment.bytes,
                             to_us(environment.created_at));
    return {};
  });
}

Result<void> EnvironmentRepository::rename(const std::string& owner_id, const std::string& id,
                                           const std::string& name) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "UPDATE environments SET name = $3 WHERE owner_id = $1::uuid AND id = $2::uuid", owner_id,
        id, name);
    if (done.affected_rows() == 0) return no_environment();
    return {};
  });
}

Result<void> EnvironmentRepository::remove(const std::string& owner_id, const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const auto done = transaction.exec_params(
        "DELETE FROM environments WHERE owner_id = $1::uuid AND id = $2::uuid", owner_id, id);
    if (done.affected_rows() == 0) return no_environment();
    return {};
  });
}

}  // namespace diaphane::api
