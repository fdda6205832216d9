#include <algorithm>
#include <charconv>

#include "api/administration/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::int64_t kMostBytes = std::int64_t{1} << 50;
constexpr std::int64_t kMostMs =
    31LL * 24 * 3600 * 1000 * 1000;  // 1000 GPUs for a month of 31 days

nlohmann::ordered_json to_json(const UserRecord& user) {
  nlohmann::ordered_json json{
      {"id", user.id},
      {"email", user.email},
      {"created_at", rfc3339(user.created_at)},
      {"used_at", nullptr},
      {"verified", user.verified},
      {"disabled", user.disabled},
      {"administrator", user.administrator},
      {"researcher", user.researcher},
      {"archive_access", user.archive_access},
      {"quota", {{"bytes", user.storage.bytes}, {"used_bytes", user.storage.used}}},
      {"render_time", {{"quota_ms", user.render_quota_ms}, {"used_ms", user.render_used_ms}}},
      {"data_sets", user.data_sets}};
  if (user.used_at) json["used_at"] = rfc3339(*user.used_at);
  return json;
}

nlohmann::ordered_json id_or_null(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(text);
}

nlohmann::ordered_json to_json(const AuditRecord& record) {
  return {{"id", record.id},
          {"happened_at", rfc3339(record.happened_at)},
          {"actor", record.actor},
          {"actor_id", id_or_null(record.actor_id)},
          {"actor_email", id_or_null(record.actor_email)},
          {"action", record.action},
          {"subject", record.subject},
          {"subject_id", id_or_null(record.subject_id)},
          {"subject_email", id_or_null(record.subject_email)},
          {"details", nlohmann::ordered_json::parse(record.details)}};
}

Outcome<Response> list_users(Administration& administration, const Request& request,
                             const Principal& who) {
  const auto limit = integer_in_query(request, "limit", 50, 1, 100);
  DIAPHANE_TRY(limit);
  auto after = cursor_in_query(request);
  DIAPHANE_TRY(after);
  auto part = text_in_query(request, "query", 254);
  DIAPHANE_TRY(part);
  const auto page = administration.users(who, *part, *std::move(after), *limit);
  DIAPHANE_TRY(page);
  nlohmann::ordered_json body{{"items", nlohmann::ordered_json::array()}, {"next_cursor", nullptr}};
  for (const UserRecord& user : page->items) body["items"].push_back(to_json(user));
  if (page->next) body["next_cursor"] = encode_cursor(*page->next);
  return json_response(200, body);
}

Outcome<Response> change_user(Administration& administration, const Request& request,
                              const Principal& who) {
  Fields in(request);
  const UserChange change{in.optional_integer("quota_bytes", 0, kMostBytes),
                          in.optional_integer("render_quota_ms", 0, kMostMs),
                          in.optional_boolean("disabled"), in.optional_boolean("researcher"),
                          in.optional_boolean("archive_access")};
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto user = administration.change(who, request.parameter("user_id"), change);
  DIAPHANE_TRY(user);
  return json_response(200, to_json(*user));
}

Outcome<Response> list_audit(Administration& administration, const Request& request,
                             const Principal& who) {
  AuditFilter filter;
  const auto limit = integer_in_query(request, "limit", 50, 1, 200);
  DIAPHANE_TRY(limit);
  filter.limit = *limit;
  auto account = text_in_query(request, "account", 36);
  DIAPHANE_TRY(account);
  if (!account->empty() && !is_id(*account)) return refuse_field("account", "must be an ID");
  filter.account_id = *std::move(account);
  auto action = text_in_query(request, "action", 60);
  DIAPHANE_TRY(action);
  filter.action = *std::move(action);
  for (auto [name, moment] : {std::pair{"from", &filter.from}, std::pair{"until", &filter.until}}) {
    if (!request.query.contains(name)) continue;
    *moment = time_of(request.query.at(name));
    if (!*moment) return refuse_field(name, "must be a UTC time such as 2026-11-22T10:00:00Z");
  }
  if (const auto given = request.query.find("cursor"); given != request.query.end()) {
    std::int64_t id = 0;
    const std::string& text = given->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (error != std::errc() || end != text.data() + text.size() || id < 1) {
      return refuse_field("cursor", "is not a valid cursor");
    }
    filter.before_id = id;
  }
  const auto page = administration.audit(who, std::move(filter));
  DIAPHANE_TRY(page);
  nlohmann::ordered_json body{{"items", nlohmann::ordered_json::array()}, {"next_cursor", nullptr}};
  for (const AuditRecord& record : page->items) body["items"].push_back(to_json(record));
  if (page->next) body["next_cursor"] = std::to_string(*page->next);
  return json_response(200, body);
}

Outcome<Response> show_fleet(Administration& administration) {
  const auto fleet = administration.fleet();
  DIAPHANE_TRY(fleet);
  nlohmann::ordered_json workers = nlohmann::ordered_json::array();
  for (const WorkerInfo& worker : fleet->workers) {
    workers.push_back({{"id", worker.id},
                       {"engine", worker.engine},
                       {"device", worker.device},
                       {"slots", worker.slots},
                       {"used", worker.used},
                       {"load", worker.load},
                       {"draining", worker.draining},
                       {"volumes", worker.volumes.size()}});
  }
  return json_response(
      200, {{"workers", std::move(workers)},
            {"ingest", {{"queued", fleet->ingest.queued}, {"building", fleet->ingest.building}}}});
}

}  // namespace

std::vector<Route> admin_routes(Administration& administration) {
  const auto users = [&administration](const Request& request, const Principal& who) {
    return list_users(administration, request, who);
  };
  const auto user = [&administration](const Request& request,
                                      const Principal& who) -> Outcome<Response> {
    const auto found = administration.user(who, request.parameter("user_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto change = [&administration](const Request& request, const Principal& who) {
    return change_user(administration, request, who);
  };
  const auto audit = [&administration](const Request& request, const Principal& who) {
    return list_audit(administration, request, who);
  };
  const auto fleet = [&administration](const Request&, const Principal&) {
    return show_fleet(administration);
  };
  constexpr auto kAdministrator = Access::kAdministrator;
  const std::string one = "/v1/admin/users/{user_id}";
  return {
      {"GET", "/v1/admin/users", "listUsers", kAdministrator, users, {"query", "limit", "cursor"}},
      {"GET", one, "getUser", kAdministrator, user, {}},
      {"PATCH", one, "changeUser", kAdministrator, change, {}},
      {"GET",
       "/v1/admin/audit",
       "listAudit",
       kAdministrator,
       audit,
       {"account", "action", "from", "until", "limit", "cursor"}},
      {"GET", "/v1/admin/fleet", "getFleet", kAdministrator, fleet, {}},
  };
}

}  // namespace diaphane::api
