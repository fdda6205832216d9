#include <functional>

#include "api/handlers/representations.h"
#include "api/handlers/request_fields.h"
#include "api/handlers/routes.h"
#include "common/try.h"

namespace diaphane::api {

std::vector<Route> report_routes(Reports& reports) {
  // Reports the data set or preset that the path names, with the reason and the words of the
  // request.
  using Note = std::function<Outcome<void>(const Request&, const Principal&, const std::string&,
                                           const std::string&)>;
  const auto reported = [](const Note& note) {
    return [note](const Request& request, const Principal& who) -> Outcome<Response> {
      Fields in(request);
      const std::string reason = in.choice("reason", kReportReasons);
      const std::string words = in.prose_or("words", "", 1000);
      if (auto wrong = in.finish()) return tl::unexpected(*wrong);
      const auto done = note(request, who, reason, words);
      DIAPHANE_TRY(done);
      return empty_response(204);
    };
  };
  const auto report = reported([&reports](const Request& request, const Principal& who,
                                          const std::string& reason, const std::string& words) {
    return reports.report(who, request.parameter("data_set_id"), reason, words);
  });
  const auto report_preset =
      reported([&reports](const Request& request, const Principal& who, const std::string& reason,
                          const std::string& words) {
        return reports.report_preset(who, request.parameter("preset_id"), reason, words);
      });
  const auto list = [&reports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto open = reports.open(who);
    DIAPHANE_TRY(open);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const Report& one : *open) {
      body["items"].push_back(
          {{"id", one.id},
           {"data_set_id", one.data_set_id},
           {"title", one.title},
           {"preset_id", one.preset_id.empty() ? nlohmann::ordered_json()
                                               : nlohmann::ordered_json(one.preset_id)},
           {"preset_name", one.preset_name},
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
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  using Judge =
      std::function<Outcome<void>(const Request&, const Principal&, const std::string& reason)>;
  const auto taken_down = [](const Judge& judge) {
    return [judge](const Request& request, const Principal& who) -> Outcome<Response> {
      Fields in(request);
      const std::string reason = in.text("reason", 1, 500);
      if (auto wrong = in.finish()) return tl::unexpected(*wrong);
      const auto done = judge(request, who, reason);
      DIAPHANE_TRY(done);
      return empty_response(204);
    };
  };
  const auto take_down = taken_down(
      [&reports](const Request& request, const Principal& who, const std::string& reason) {
        return reports.take_down(who, request.parameter("data_set_id"), reason);
      });
  const auto take_down_preset = taken_down(
      [&reports](const Request& request, const Principal& who, const std::string& reason) {
        return reports.take_down_preset(who, request.parameter("preset_id"), reason);
      });
  const auto restore = [&reports](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto done = reports.restore(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto restore_preset = [&reports](const Request& request,
                                         const Principal& who) -> Outcome<Response> {
    const auto done = reports.restore_preset(who, request.parameter("preset_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string of_data_set = "/v1/data-sets/{data_set_id}";
  const std::string down = of_data_set + "/take-down";
  const std::string preset = "/v1/presets/{preset_id}";
  constexpr auto kAdmin = Access::kAdministrator;
  return {
      {"POST", of_data_set + "/reports", "reportDataSet", Access::kPerson, report, {}},
      {"POST", down, "takeDownDataSet", kAdmin, take_down, {}},
      {"DELETE", down, "restoreDataSet", kAdmin, restore, {}},
      {"POST", preset + "/reports", "reportPreset", Access::kPerson, report_preset, {}},
      {"POST", preset + "/take-down", "takeDownPreset", kAdmin, take_down_preset, {}},
      {"DELETE", preset + "/take-down", "restorePreset", kAdmin, restore_preset, {}},
      {"GET", "/v1/reports", "listReports", kAdmin, list, {}},
      {"DELETE", "/v1/reports/{report_id}", "dismissReport", kAdmin, dismiss, {}},
  };
}

}  // namespace diaphane::api
