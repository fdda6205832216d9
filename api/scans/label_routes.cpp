#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/data_set_format.h"
#include "api/scans/routes.h"
#include "common/try.h"

namespace diaphane::api {

std::vector<Route> label_routes(ScanLabels& labels) {
  const auto announce = [&labels](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const auto bytes = in.integer("bytes", 1, INT64_MAX);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto scan = labels.announce(who, request.parameter("data_set_id"), bytes);
    DIAPHANE_TRY(scan);
    nlohmann::ordered_json body{{"data_set", to_json(*scan)}, {"upload_url", nullptr}};
    if (scan->labels.upload) body["upload_url"] = "/v1/uploads/" + scan->labels.upload->id;
    return json_response(201, body);
  };
  const auto remove = [&labels](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto done = labels.remove(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string path = "/v1/data-sets/{data_set_id}/labels";
  constexpr auto kAccess = Access::kPersonOrOperator;
  return {{"POST", path, "addLabels", kAccess, announce, {}},
          {"DELETE", path, "removeLabels", kAccess, remove, {}}};
}

}  // namespace diaphane::api
