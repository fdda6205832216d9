#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "api/sharing/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr auto kAdmin = Access::kAdministrator;

/// A user's complaint about the data set or preset in the path.
struct Complaint {
  std::string reason, words;
};

Outcome<Complaint> read_complaint(const Request& request) {
  Fields in(request);
  Complaint complaint;
  complaint.reason = in.choice("reason", kReportReasons);
  complaint.words = in.prose_or("words", "", 1000);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return complaint;
}

/// Reads an administrator's reason for taking something down.
Outcome<std::string> read_reason(const Request& request) {
  Fields in(request);
  std::string reason = in.text("reason", 1, 500);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return reason;
}

nlohmann::ordered_json null_if_empty(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

nlohmann::ordered_json to_json(const TakeDown& one) {
  return {{"data_set_id", one.data_set_id},
          {"title", one.title},
          {"preset_id", null_if_empty(one.preset_id)},
          {"preset_name", one.preset_name},
          {"reason", one.reason},
          {"taken_down_at", rfc3339(one.taken_down_at)}};
}

nlohmann::ordered_json to_json(const Report& report) {
  return {{"id", report.id},
          {"data_set_id", report.data_set_id},
          {"title", report.title},
          {"preset_id", null_if_empty(report.preset_id)},
          {"preset_name", report.preset_name},
          {"reason", report.reason},
          {"words", report.words},
          {"taken_down", report.taken_down},
          {"created_at", rfc3339(report.created_at)}};
}

std::vector<Route> routes_of_data_set(Reports& reports) {
  const auto report = [&reports](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto complaint = read_complaint(request);
    DIAPHANE_TRY(complaint);
    return answer(
        reports.report(who, request.parameter("data_set_id"), complaint->reason, complaint->words));
  };
  const auto take_down = [&reports](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto reason = read_reason(request);
    DIAPHANE_TRY(reason);
    return answer(reports.take_down(who, request.parameter("data_set_id"), *reason));
  };
  const auto restore = [&reports](const Request& request, const Principal& who) {
    return answer(reports.restore(who, request.parameter("data_set_id")));
  };
  const std::string one = "/v1/data-sets/{data_set_id}";
  return {
      {"POST", one + "/reports", "reportDataSet", Access::kPerson, report, {}},
      {"POST", one + "/take-down", "takeDownDataSet", kAdmin, take_down, {}},
      {"DELETE", one + "/take-down", "restoreDataSet", kAdmin, restore, {}},
  };
}

std::vector<Route> routes_of_preset(Reports& reports) {
  const auto report = [&reports](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto complaint = read_complaint(request);
    DIAPHANE_TRY(complaint);
    return answer(reports.report_preset(who, request.parameter("preset_id"), complaint->reason,
                                        complaint->words));
  };
  const auto take_down = [&reports](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto reason = read_reason(request);
    DIAPHANE_TRY(reason);
    return answer(reports.take_down_preset(who, request.parameter("preset_id"), *reason));
  };
  const auto restore = [&reports](const Request& request, const Principal& who) {
    return answer(reports.restore_preset(who, request.parameter("preset_id")));
  };
  const std::string one = "/v1/presets/{preset_id}";
  return {
      {"POST", one + "/reports", "reportPreset", Access::kPerson, report, {}},
      {"POST", one + "/take-down", "takeDownPreset", kAdmin, take_down, {}},
      {"DELETE", one + "/take-down", "restorePreset", kAdmin, restore, {}},
  };
}

std::vector<Route> routes_of_reports(Reports& reports) {
  const auto list = [&reports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto open = reports.open(who);
    DIAPHANE_TRY(open);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const Report& one : *open) body["items"].push_back(to_json(one));
    return json_response(200, body);
  };
  const auto count = [&reports](const Request&, const Principal&) -> Outcome<Response> {
    const auto open = reports.count_open();
    DIAPHANE_TRY(open);
    return json_response(200, nlohmann::ordered_json{{"open", *open}});
  };
  const auto dismiss = [&reports](const Request& request, const Principal& who) {
    return answer(reports.close(who, request.parameter("report_id")));
  };
  const auto taken_down = [&reports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto found = reports.taken_down(who);
    DIAPHANE_TRY(found);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const TakeDown& one : *found) body["items"].push_back(to_json(one));
    return json_response(200, body);
  };
  return {
      {"GET", "/v1/take-downs", "listTakeDowns", kAdmin, taken_down, {}},
      {"GET", "/v1/reports", "listReports", kAdmin, list, {}},
      {"GET", "/v1/report-count", "countReports", kAdmin, count, {}},
      {"DELETE", "/v1/reports/{report_id}", "dismissReport", kAdmin, dismiss, {}},
  };
}

}  // namespace

std::vector<Route> report_routes(Reports& reports) {
  return join({routes_of_data_set(reports), routes_of_preset(reports), routes_of_reports(reports)});
}

}  // namespace diaphane::api
