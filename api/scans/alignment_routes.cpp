#include "api/routing/representations.h"
#include "api/scans/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

nlohmann::ordered_json to_json(const Alignment& one) {
  nlohmann::ordered_json json{
      {"state", one.state},     {"frame_of_reference_shared", one.shares_frame},
      {"matrix", nullptr},      {"scene_matrix", nullptr},
      {"residual_mm", nullptr}, {"overlap", nullptr},
      {"reason", nullptr},      {"may_align", one.may_align}};
  if (one.state == "ready") json["matrix"] = one.matrix;
  if (one.scene_matrix) json["scene_matrix"] = *one.scene_matrix;
  if (one.residual_mm) json["residual_mm"] = *one.residual_mm;
  if (one.overlap) json["overlap"] = *one.overlap;
  if (!one.reason.empty()) json["reason"] = one.reason;
  return json;
}

}  // namespace

std::vector<Route> alignment_routes(Alignments& alignments) {
  const auto get = [&alignments](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto found = alignments.find(who, request.parameter("data_set_id"),
                                       request.parameter("second_data_set_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto put = [&alignments](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto found = alignments.request(who, request.parameter("data_set_id"),
                                          request.parameter("second_data_set_id"));
    DIAPHANE_TRY(found);
    return json_response(found->made ? 201 : 200, to_json(found->alignment));
  };
  const auto remove = [&alignments](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto done = alignments.remove(who, request.parameter("data_set_id"),
                                        request.parameter("second_data_set_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string path = "/v1/data-sets/{data_set_id}/alignments/{second_data_set_id}";
  return {{"GET", path, "getAlignment", Access::kPerson, get, {}},
          {"PUT", path, "requestAlignment", Access::kPerson, put, {}},
          {"DELETE", path, "deleteAlignment", Access::kPerson, remove, {}}};
}

}  // namespace diaphane::api
