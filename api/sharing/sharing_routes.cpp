#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/data_set_format.h"
#include "api/sharing/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::array<std::string_view, 2> kVisibilities{"private", "public"};
constexpr std::array<std::string_view, 2> kRights{"view", "save"};
constexpr int kLongestLink = 24 * 90;  // hours

nlohmann::ordered_json to_json(const SharedPerson& person) {
  return {{"id", person.id},
          {"email", person.email_key},
          {"may", person.may_save ? "save" : "view"},
          {"slices", person.allowed.slices},
          {"downloads", person.allowed.downloads},
          {"created_at", rfc3339(person.created_at)}};
}

nlohmann::ordered_json to_json(const DataSetLink& link) {
  return {{"id", link.id},
          {"created_at", rfc3339(link.created_at)},
          {"expires_at", rfc3339(link.expires_at)},
          {"slices", link.allowed.slices},
          {"downloads", link.allowed.downloads}};
}

/// Reads "slices" and "downloads", which default to `otherwise`.
Permissions permissions_in(Fields& in, bool otherwise) {
  Permissions allowed;
  allowed.slices = in.optional_boolean("slices").value_or(otherwise);
  allowed.downloads = in.optional_boolean("downloads").value_or(otherwise);
  return allowed;
}

template <typename Item>
Response list_response(const std::vector<Item>& items) {
  nlohmann::ordered_json body;
  body["items"] = nlohmann::ordered_json::array();
  for (const Item& item : items) body["items"].push_back(to_json(item));
  return json_response(200, body);
}

Outcome<Response> gallery(Sharing& sharing, const Request& request, const Principal& who) {
  GalleryQuery query;
  const auto limit = integer_in_query(request, "limit", 24, 1, 100);
  DIAPHANE_TRY(limit);
  auto words = text_in_query(request, "q", 100);
  DIAPHANE_TRY(words);
  auto body_part = choice_in_query(request, "body_part", kBodyParts);
  DIAPHANE_TRY(body_part);
  auto modality = choice_in_query(request, "modality", kModalities);
  DIAPHANE_TRY(modality);
  auto after = cursor_in_query(request);
  DIAPHANE_TRY(after);
  query.after = *std::move(after);
  query.limit = *limit;
  query.words = *std::move(words);
  query.body_part = *std::move(body_part);
  query.modality = *std::move(modality);
  const auto page = sharing.gallery(who, std::move(query));
  DIAPHANE_TRY(page);
  nlohmann::ordered_json body;
  body["items"] = nlohmann::ordered_json::array();
  for (const DataSet& data_set : page->items) body["items"].push_back(api::to_json(data_set));
  body["next_cursor"] = nullptr;
  if (page->next) body["next_cursor"] = encode_cursor(*page->next);
  return json_response(200, body);
}

std::vector<Route> people_routes(Sharing& sharing) {
  const auto list = [&sharing](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = sharing.people(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    return list_response(*found);
  };
  const auto add = [&sharing](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string email = in.text("email", 3, 254);
    const std::string right = in.choice("may", kRights);
    const Permissions allowed = permissions_in(in, true);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done =
        sharing.share_with(who, request.parameter("data_set_id"), email, right == "save", allowed);
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto change = [&sharing](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    Fields in(request);
    PersonChange to;
    if (in.has("may")) to.may_save = in.choice("may", kRights) == "save";
    to.slices = in.optional_boolean("slices");
    to.downloads = in.optional_boolean("downloads");
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done = sharing.change_person(who, request.parameter("data_set_id"),
                                            request.parameter("person_id"), to);
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto remove = [&sharing](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto done =
        sharing.unshare(who, request.parameter("data_set_id"), request.parameter("person_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string people = "/v1/data-sets/{data_set_id}/people";
  return {
      {"GET", people, "listPeople", Access::kPerson, list, {}},
      {"POST", people, "shareWithPerson", Access::kPerson, add, {}},
      {"PATCH", people + "/{person_id}", "changePerson", Access::kPerson, change, {}},
      {"DELETE", people + "/{person_id}", "unsharePerson", Access::kPerson, remove, {}},
  };
}

std::vector<Route> link_routes(Sharing& sharing, const RequestRouter& router) {
  const auto list = [&sharing](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = sharing.links(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    return list_response(*found);
  };
  const auto make = [&sharing, &router](const Request& request,
                                        const Principal& who) -> Outcome<Response> {
    const auto once = idempotency_scope_of(request, router);
    DIAPHANE_TRY(once);
    Fields in(request);
    const std::chrono::hours life(in.integer("hours", 1, kLongestLink));
    const Permissions allowed = permissions_in(in, false);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto made =
        sharing.make_link(who, request.parameter("data_set_id"), life, allowed, *once);
    DIAPHANE_TRY(made);
    auto body = to_json(made->link);
    body["token"] = made->token;
    body["path"] = "/shared#" + made->token;
    return json_response(201, body);
  };
  const auto end = [&sharing](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto done =
        sharing.end_link(who, request.parameter("data_set_id"), request.parameter("link_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string links = "/v1/data-sets/{data_set_id}/links";
  return {
      {"GET", links, "listDataSetLinks", Access::kPerson, list, {}},
      {"POST", links, "createDataSetLink", Access::kPerson, make, {}},
      {"DELETE", links + "/{link_id}", "endDataSetLink", Access::kPerson, end, {}},
  };
}

}  // namespace

std::vector<Route> sharing_routes(Sharing& sharing, const RequestRouter& router) {
  const auto browse = [&sharing](const Request& request, const Principal& who) {
    return gallery(sharing, request, who);
  };
  const auto show = [&sharing](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string visibility = in.choice("visibility", kVisibilities);
    const Permissions allowed = permissions_in(in, false);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const std::string& id = request.parameter("data_set_id");
    const auto changed =
        visibility == "public" ? sharing.publish(who, id, allowed) : sharing.make_private(who, id);
    DIAPHANE_TRY(changed);
    return json_response(200, api::to_json(*changed));
  };
  const auto get_name = [&sharing](const Request&, const Principal& who) -> Outcome<Response> {
    const auto name = sharing.public_name(who);
    DIAPHANE_TRY(name);
    return json_response(200, {{"public_name", *name}});
  };
  const auto set_name = [&sharing](const Request& request,
                                   const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string name = in.name("public_name", 0, 40);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done = sharing.set_public_name(who, name);
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  std::vector<Route> routes{
      {"GET",
       "/v1/gallery",
       "listGallery",
       Access::kAnyoneOrPerson,
       browse,
       {"q", "body_part", "modality", "limit", "cursor"}},
      {"POST",
       "/v1/data-sets/{data_set_id}/visibility",
       "setVisibility",
       Access::kPerson,
       show,
       {}},
      {"GET", "/v1/me/public-name", "getPublicName", Access::kPerson, get_name, {}},
      {"PATCH", "/v1/me/public-name", "setPublicName", Access::kPerson, set_name, {}},
  };
  for (auto more : {people_routes(sharing), link_routes(sharing, router)}) {
    routes.insert(routes.end(), more.begin(), more.end());
  }
  return routes;
}

std::vector<Route> visit_routes(Visits& visits, Thumbnails& thumbnails) {
  const auto follow = [&visits](const Request& request, const Principal&) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 64, 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto found = visits.follow(token);
    DIAPHANE_TRY(found);
    return json_response(200, {{"data_set", api::to_json(found->data_set)},
                               {"expires_at", rfc3339(found->link.expires_at)}});
  };
  const auto thumbnail = [&visits, &thumbnails](const Request& request,
                                                const Principal&) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 64, 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto linked = [&]() -> Outcome<Thumbnails::Linked> {
      auto found = visits.follow(token);
      DIAPHANE_TRY(found);
      return Thumbnails::Linked{std::move(found->data_set), std::move(found->link.id)};
    };
    const auto path = thumbnails.get_with_link(linked, request.parameter("preset"));
    DIAPHANE_TRY(path);
    return cached_picture(*path);
  };
  const auto open = [&visits](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string key = in.text("key", 64, 64);
    const std::string token = in.text_or("token", "", 64);
    const std::string data_set_id = in.text_or("data_set_id", "", 64);
    if (token.empty() == data_set_id.empty()) {
      in.wrong("token", "must be given, or else the data_set_id of a sample, but not both");
    }
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto opened = visits.open(token, data_set_id, key, who.client);
    DIAPHANE_TRY(opened);
    return json_response(201, {{"session_id", opened->session_id},
                               {"stream_url", opened->stream_url},
                               {"expires_at", rfc3339(opened->expires_at)}});
  };
  return {
      {"POST", "/v1/follow", "followLink", Access::kAnyone, follow, {}},
      {"POST",
       "/v1/follow/thumbnails/{preset}",
       "followLinkThumbnail",
       Access::kAnyone,
       thumbnail,
       {}},
      {"POST", "/v1/visits", "createVisit", Access::kAnyone, open, {}},
  };
}

}  // namespace diaphane::api
