#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "api/studies/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kIdLength = 64;

Outcome<Response> tour_response(const Outcome<Studies::Tour>& found) {
  DIAPHANE_TRY(found);
  ordered_json tour;
  if (!found->document.empty()) {
    tour = ordered_json::parse(found->document);
    tour["removable"] = found->removable;
  }
  return json_response(200, {{"tour", tour}});
}

}  // namespace

std::vector<Route> tour_routes(Studies& studies, Visits& visits) {
  const auto get = [&studies](const Request& request, const Principal& who) {
    return tour_response(studies.tour(who, request.parameter("data_set_id")));
  };
  const auto follow = [&](const Request& request, const Principal&) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 64, 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto leads = visits.follow(token);
    DIAPHANE_TRY(leads);
    return tour_response(studies.tour_of(leads->data_set.id));
  };
  const auto adopt = [&studies](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string study = in.text("study_id", 1, kIdLength);
    const std::string step = in.text("step", 1, kIdLength);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(studies.adopt_tour(who, request.parameter("data_set_id"), study, step));
  };
  const auto remove = [&studies](const Request& request, const Principal& who) {
    return answer(studies.remove_tour(who, request.parameter("data_set_id")));
  };
  const std::string one = "/v1/data-sets/{data_set_id}/tour";
  return {
      {"GET", one, "getTour", Access::kAnyoneOrPerson, get, {}},
      {"POST", "/v1/follow/tour", "followLinkTour", Access::kAnyone, follow, {}},
      {"PUT", one, "adoptTour", Access::kResearcher, adopt, {}},
      {"DELETE", one, "removeTour", Access::kPerson, remove, {}},
  };
}

}  // namespace diaphane::api
