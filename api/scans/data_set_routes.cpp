#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/data_set_format.h"
#include "api/scans/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::array<std::string_view, 2> kYesOrNo{"true", "false"};

Outcome<Response> list(DataSets& data_sets, const Request& request, const Principal& who) {
  const auto limit = integer_in_query(request, "limit", 50, 1, 100);
  DIAPHANE_TRY(limit);
  auto after = cursor_in_query(request);
  DIAPHANE_TRY(after);
  const auto page = data_sets.list(who, *after, *limit);
  DIAPHANE_TRY(page);
  nlohmann::ordered_json body;
  body["items"] = nlohmann::ordered_json::array();
  for (const DataSet& data_set : page->items) body["items"].push_back(to_json(data_set));
  body["next_cursor"] = nullptr;
  if (page->next) body["next_cursor"] = encode_cursor(*page->next);
  return json_response(200, body);
}

Outcome<Response> create_data_set(DataSets& data_sets, const Request& request,
                                  const Principal& who) {
  auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  Fields in(request);
  DataSets::Announcement announcement{in.has("title") ? in.name("title", 0, 80) : std::string(),
                                      in.integer("bytes", 1, INT64_MAX), *std::move(key)};
  in.integer_or("slices", 1, 1, 100'000);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto made = data_sets.announce(who, announcement);
  DIAPHANE_TRY(made);
  return json_response(201,
                       {{"data_set", to_json(*made)}, {"upload_url", "/v1/uploads/" + made->id}})
      .with("Location", "/v1/data-sets/" + made->id);
}

nlohmann::ordered_json to_json(const ViewEntry& entry, const std::string& here) {
  nlohmann::ordered_json json{{"id", entry.id},
                              {"route", to_string(entry.route)},
                              {"email", nullptr},
                              {"link_created_at", nullptr},
                              {"network", entry.network},
                              {"same_network", !here.empty() && entry.network == here},
                              {"browser", entry.browser},
                              {"first_at", rfc3339(entry.first_at)},
                              {"last_at", rfc3339(entry.last_at)},
                              {"times", entry.times}};
  if (!entry.email_key.empty()) json["email"] = entry.email_key;
  if (entry.link_created_at) json["link_created_at"] = rfc3339(*entry.link_created_at);
  return json;
}

Outcome<Response> list_views(DataSets& data_sets, const Request& request, const Principal& who) {
  const auto limit = integer_in_query(request, "limit", 50, 1, 100);
  DIAPHANE_TRY(limit);
  auto after = cursor_in_query(request);
  DIAPHANE_TRY(after);
  const auto own = choice_in_query(request, "own", kYesOrNo);
  DIAPHANE_TRY(own);
  const auto page = data_sets.views(who, request.parameter("data_set_id"),
                                    {*own != "false", *std::move(after), *limit});
  DIAPHANE_TRY(page);
  const std::string here = coarse_network(who.client.address);
  nlohmann::ordered_json body;
  body["items"] = nlohmann::ordered_json::array();
  for (const ViewEntry& entry : page->items) body["items"].push_back(to_json(entry, here));
  body["next_cursor"] = nullptr;
  if (page->next) body["next_cursor"] = encode_cursor(*page->next);
  return json_response(200, body);
}

}  // namespace

std::vector<Route> data_set_routes(DataSets& data_sets, Thumbnails& thumbnails) {
  const auto list_them = [&data_sets](const Request& request, const Principal& who) {
    return list(data_sets, request, who);
  };
  const auto create_one = [&data_sets](const Request& request, const Principal& who) {
    return create_data_set(data_sets, request, who);
  };
  const auto get_one = [&data_sets](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto found = data_sets.find(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto describe_one = [&data_sets](const Request& request,
                                         const Principal& who) -> Outcome<Response> {
    Fields in(request);
    Description what;
    if (in.has("title")) what.title = in.name("title", 0, 80);
    if (in.has("description")) what.text = in.prose_or("description", "", 2000);
    if (in.is_null("body_part")) {
      what.body_part = "";
    } else if (in.has("body_part")) {
      what.body_part = in.choice("body_part", kBodyParts);
    }
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto described = data_sets.describe(who, request.parameter("data_set_id"), what);
    DIAPHANE_TRY(described);
    return json_response(200, to_json(*described));
  };
  const auto delete_one = [&data_sets](const Request& request,
                                       const Principal& who) -> Outcome<Response> {
    const auto done = data_sets.remove(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto thumbnail = [&thumbnails](const Request& request,
                                       const Principal& who) -> Outcome<Response> {
    const auto path =
        thumbnails.get(who, request.parameter("data_set_id"), request.parameter("preset"));
    DIAPHANE_TRY(path);
    return cached_picture(*path);
  };
  const auto views = [&data_sets](const Request& request, const Principal& who) {
    return list_views(data_sets, request, who);
  };
  const std::string one = "/v1/data-sets/{data_set_id}";
  constexpr auto kAccess = Access::kPersonOrOperator;
  return {
      {"GET", "/v1/data-sets", "listDataSets", kAccess, list_them, {"limit", "cursor"}},
      {"POST", "/v1/data-sets", "createDataSet", kAccess, create_one, {}},
      {"GET", one, "getDataSet", kAccess, get_one, {}},
      {"PATCH", one, "describeDataSet", kAccess, describe_one, {}},
      {"DELETE", one, "deleteDataSet", kAccess, delete_one, {}},
      {"GET", one + "/views", "listViews", Access::kPerson, views, {"own", "limit", "cursor"}},
      {"GET", one + "/thumbnails/{preset}", "getThumbnail", Access::kAnyoneOrPerson, thumbnail, {}},
  };
}

}  // namespace diaphane::api
