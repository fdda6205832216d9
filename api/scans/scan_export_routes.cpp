#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/routes.h"
#include "common/try.h"
#include "volume/volume.h"

namespace diaphane::api {
namespace {

nlohmann::ordered_json to_json(const ScanExport& one) {
  nlohmann::ordered_json json{{"state", one.state},
                              {"waiting", one.waiting && one.state == "queued"},
                              {"format", one.order.format},
                              {"label", nullptr},
                              {"above", nullptr},
                              {"phase", one.order.phase},
                              {"bytes", nullptr},
                              {"problem", nullptr},
                              {"created_at", rfc3339(one.created_at)},
                              {"expires_at", rfc3339(one.expires_at)}};
  if (one.order.label) json["label"] = *one.order.label;
  if (one.order.above) json["above"] = *one.order.above;
  if (one.state == "ready") json["bytes"] = one.bytes;
  if (one.state == "failed")
    json["problem"] = {{"code", one.problem_code}, {"text", one.problem_text}};
  return json;
}

Outcome<ScanExportOrder> read_order(const Request& request) {
  Fields in(request);
  ScanExportOrder order;
  order.format = in.choice("format", kScanExportFormats);
  if (!in.is_null("label")) order.label = in.optional_integer("label", 1, UINT32_MAX);
  if (!in.is_null("above")) order.above = in.optional_integer("above", INT16_MIN, INT16_MAX);
  if (!in.is_null("phase"))
    order.phase = in.optional_integer("phase", 0, volume::kMostPhases - 1).value_or(0);
  if (order.phase > 0 && !order.above) in.wrong("phase", "is for above");
  if (order.format == "nifti") {
    if (order.label) in.wrong("label", "must be absent for nifti, which contains the whole scan");
    if (order.above) in.wrong("above", "must be absent for nifti, which contains the whole scan");
  } else if (order.label.has_value() == order.above.has_value()) {
    in.wrong("label", "a surface needs either label or above");
  }
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return order;
}

}  // namespace

std::vector<Route> scan_export_routes(ScanExports& exports) {
  const auto request_one = [&exports](const Request& request,
                                      const Principal& who) -> Outcome<Response> {
    const auto order = read_order(request);
    DIAPHANE_TRY(order);
    const auto made = exports.request(who, request.parameter("data_set_id"), *order);
    DIAPHANE_TRY(made);
    return json_response(202, to_json(*made));
  };
  const auto get = [&exports](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = exports.find(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto remove = [&exports](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto done = exports.remove(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto download = [&exports](const Request& request,
                                   const Principal& who) -> Outcome<Response> {
    const auto file = exports.file(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(file);
    // nginx sends the file.
    Response response;
    response.content_type = file->content_type;
    return std::move(response)
        .with("X-Accel-Redirect", "/_cache/exports/" + file->stored)
        .with("Content-Disposition", "attachment; filename=\"" + file->name + "\"")
        .with("Cache-Control", "no-store");
  };
  const std::string path = "/v1/data-sets/{data_set_id}/export";
  return {{"POST", path, "requestScanExport", Access::kPerson, request_one, {}},
          {"GET", path, "getScanExport", Access::kPerson, get, {}},
          {"DELETE", path, "deleteScanExport", Access::kPerson, remove, {}},
          {"GET", path + "/file", "downloadScanExport", Access::kPerson, download, {}}};
}

}  // namespace diaphane::api
