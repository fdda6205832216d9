#include "api/sessions/render_time_repository.h"

namespace diaphane::api {

Result<std::vector<std::string>> RenderTimeRepository::add(
    const std::vector<std::pair<std::string, std::int64_t>>& spent, Time now,
    Time ended_if_warned_by) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> over;
    for (const auto& [viewer, ms] : spent) {
      // The researcher pays for the participants of their studies.
      const auto user = transaction
                            .exec_params1(
                                R"sql(
                  SELECT COALESCE((SELECT s.owner_id FROM study_participants p JOIN studies s ON s.id = p.study_id
                                    WHERE p.id = $1::uuid), $1::uuid))sql",
                                viewer)[0]
                            .as<std::string>();
      transaction.exec_params0(
          R"sql(
          INSERT INTO render_time AS r (user_id, month, device_ms)
          SELECT id, date_trunc('month', to_timestamp($3::bigint / 1e6) AT TIME ZONE 'UTC')::date, $2::bigint
            FROM users WHERE id = $1::uuid
          ON CONFLICT (user_id, month) DO UPDATE SET device_ms = r.device_ms + excluded.device_ms)sql",
          user, ms, to_us(now));
      const pqxx::result warned = transaction.exec_params(
          R"sql(
          UPDATE render_time r SET warned_at = COALESCE(r.warned_at, to_timestamp($2::bigint / 1e6))
            FROM users u
           WHERE u.id = $1::uuid AND r.user_id = u.id AND r.device_ms >= u.render_quota_ms
             AND r.month = date_trunc('month', to_timestamp($2::bigint / 1e6) AT TIME ZONE 'UTC')::date
          RETURNING r.warned_at <= to_timestamp($3::bigint / 1e6) AS is_over)sql",
          user, to_us(now), to_us(ended_if_warned_by));
      if (!warned.empty() && warned[0]["is_over"].as<bool>()) over.push_back(user);
    }
    return over;
  });
}

Result<std::vector<std::string>> RenderTimeRepository::warned(Time now, Time from, Time until) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    transaction.exec_params0(
        R"sql(
        UPDATE render_time r SET warned_at = to_timestamp($1::bigint / 1e6)
          FROM users u
         WHERE u.id = r.user_id AND r.device_ms >= u.render_quota_ms AND r.warned_at IS NULL
           AND r.month = date_trunc('month', to_timestamp($1::bigint / 1e6) AT TIME ZONE 'UTC')::date)sql",
        to_us(now));
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT r.user_id FROM render_time r JOIN users u ON u.id = r.user_id
         WHERE r.device_ms >= u.render_quota_ms
           AND r.warned_at BETWEEN to_timestamp($2::bigint / 1e6) AND to_timestamp($3::bigint / 1e6)
           AND r.month = date_trunc('month', to_timestamp($1::bigint / 1e6) AT TIME ZONE 'UTC')::date)sql",
        to_us(now), to_us(from), to_us(until));
    std::vector<std::string> users;
    for (const auto& row : found) users.push_back(row["user_id"].as<std::string>());
    return users;
  });
}

Result<RenderAccount> RenderTimeRepository::account(const std::string& user_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<RenderAccount> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        WITH month AS (SELECT date_trunc('month', to_timestamp($2::bigint / 1e6) AT TIME ZONE 'UTC') AS first)
        SELECT u.render_quota_ms, COALESCE(r.device_ms, 0) AS device_ms,
               (extract(epoch FROM r.warned_at) * 1000000)::bigint AS warned_us,
               (extract(epoch FROM m.first) * 1000000)::bigint AS month_us,
               (extract(epoch FROM m.first + interval '1 month') * 1000000)::bigint AS next_month_us
          FROM users u CROSS JOIN month m
          LEFT JOIN render_time r ON r.user_id = u.id AND r.month = m.first::date
         WHERE u.id = $1::uuid)sql",
        user_id, to_us(now));
    if (found.empty()) return fail(ErrorCode::kNotFound, "Account not found.");
    RenderAccount account;
    account.quota_ms = found[0]["render_quota_ms"].as<std::int64_t>();
    account.used_ms = found[0]["device_ms"].as<std::int64_t>();
    if (!found[0]["warned_us"].is_null())
      account.warned_at = from_us(found[0]["warned_us"].as<std::int64_t>());
    account.month = from_us(found[0]["month_us"].as<std::int64_t>());
    account.next_month = from_us(found[0]["next_month_us"].as<std::int64_t>());
    return account;
  });
}

}  // namespace diaphane::api
