#include "api/handlers/representations.h"
#include "api/handlers/request_fields.h"
#include "api/handlers/routes.h"

namespace diaphane::api {

std::vector<Route> report_routes(Reports& reports) {
  const auto report = [&reports](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string reason = in.choice("reason", kReportReasons);
    const std::string words = in.prose_or("words", "", 1000);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done = reports.report(who, request.parameter("data_set_id"), reason, words);
    if (!done) return tl::unexpected(done.error());
    return empty_response(204);
  };
  const auto list = [&reports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto open = reports.open(who);
    if (!open) return tl::unexpected(open.error());
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const Report& one : *open) {
      body["items"].push_back({{"id", one.id},
                               {"data_set_id", one.data_set_id},
                               {"title", one.title},
                               {"reason", one.reason},
                               {"words", one.words},
                               {"taken_down", one.taken_down},
                               {"created_at", rfc3339(one.created_at)}});
    }
    return json_response(200, body);
  };
  const auto dismiss = [&reports](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto done = reports.close(who, request.parameter("report_id"));
    if (!done) return tl::unexpected(done.error());
    return empty_response(204);
  };
  const auto take_down = [&reports](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string reason = in.text("reason", 1, 500);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done = reports.take_down(who, request.parameter("data_set_id"), reason);
    if (!done) return tl::unexpected(done.error());
    return empty_response(204);
  };
  const auto restore = [&reports](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto done = reports.restore(who, request.parameter("data_set_id"));
    if (!done) return tl::unexpected(done.error());
    return empty_response(204);
  };
  const std::string of_data_set = "/v1/data-sets/{data_set_id}";
  const std::string down = of_data_set + "/take-down";
  constexpr auto kAdmin = Access::kAdministrator;
  return {
      {"POST", of_data_set + "/reports", "reportDataSet", Access::kPerson, report, {}},
      {"POST", down, "takeDownDataSet", kAdmin, take_down, {}},
      {"DELETE", down, "restoreDataSet", kAdmin, restore, {}},
      {"GET", "/v1/reports", "listReports", kAdmin, list, {}},
      {"DELETE", "/v1/reports/{report_id}", "dismissReport", kAdmin, dismiss, {}},
  };
}

}  // namespace diaphane::api
