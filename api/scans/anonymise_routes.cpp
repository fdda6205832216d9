#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/routes.h"
#include "common/try.h"
#include "volume/region.h"

namespace diaphane::api {
namespace {

/// The client must send this text, so that a scan is never anonymised by mistake.
constexpr const char* kConfirmation = "this cannot be undone";

nlohmann::ordered_json to_json(const Anonymise::View& view) {
  nlohmann::ordered_json body;
  body["state"] = to_string(view.data_set.state);
  body["volume_hash"] = nullptr;
  if (!view.volume_hash.empty()) body["volume_hash"] = view.volume_hash;
  body["anonymised_at"] = nullptr;
  if (view.data_set.anonymised_at) body["anonymised_at"] = rfc3339(*view.data_set.anonymised_at);
  body["problem"] = nullptr;
  if (!view.facts.problem.empty()) body["problem"] = view.facts.problem;
  body["head"] = nullptr;
  if (!view.facts.head.empty()) {
    body["head"] = nlohmann::ordered_json::parse(view.facts.head, nullptr, false);
  }
  return body;
}

Outcome<Response> cut(Anonymise& anonymise, const Request& request, const Principal& who) {
  Fields in(request);
  const nlohmann::json& keep = in.any("keep");
  const std::string hash = in.text("volume_hash", 1, 100);
  const std::string confirmation = in.text("confirm", 1, 100);
  std::string region;
  if (const auto read = volume::region_from_json(keep.dump())) {
    region = volume::to_json(*read);
  } else if (keep.is_null()) {
    in.wrong("keep", "must be a region");
  } else {
    in.wrong(read.error().field, read.error().message);
  }
  if (confirmation != kConfirmation) {
    in.wrong("confirm", std::string("must be \"") + kConfirmation + "\"");
  }
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto view = anonymise.cut(who, request.parameter("data_set_id"), region, hash);
  DIAPHANE_TRY(view);
  return json_response(202, to_json(*view));
}

}  // namespace

std::vector<Route> anonymise_routes(Anonymise& anonymise) {
  const auto look = [&anonymise](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto view = anonymise.get(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(view);
    return json_response(200, to_json(*view));
  };
  const auto carry_out = [&anonymise](const Request& request, const Principal& who) {
    return cut(anonymise, request, who);
  };
  const std::string path = "/v1/data-sets/{data_set_id}/anonymise";
  return {{"GET", path, "getAnonymise", Access::kPerson, look, {}},
          {"POST", path, "anonymise", Access::kPerson, carry_out, {}}};
}

}  // namespace diaphane::api
