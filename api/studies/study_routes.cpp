#include "api/presets/preset_format.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "api/studies/routes.h"
#include "api/studies/study_format.h"

namespace diaphane::api {
namespace {

using nlohmann::ordered_json;

constexpr std::array<std::string_view, 2> kStates{"open", "closed"}, kFormats{"json", "csv"};
constexpr std::int64_t kMostPictureUpload = 524'288;
constexpr int kMostListed = 100;

ordered_json to_json(const Study& study) {
  return {{"id", study.id},
          {"title", ordered_json::parse(study.content.title)},
          {"state", to_string(study.state)},
          {"places", study.content.places},
          {"joined", study.joined},
          {"finished", study.finished},
          {"withdrawn", study.withdrawn},
          {"ends_at", rfc3339(study.content.ends_at)},
          {"created_at", rfc3339(study.created_at)}};
}

std::string etag_of(const Study& study) { return '"' + std::to_string(study.version) + '"'; }

Response with_definition(int status, const Study& study) {
  ordered_json body = to_json(study);
  body["etag"] = etag_of(study);
  body["definition"] = ordered_json::parse(study.content.definition);
  return json_response(status, body).with("ETag", etag_of(study));
}

Outcome<Response> answer_study(const Outcome<Study>& study) {
  DIAPHANE_TRY(study);
  return with_definition(200, *study);
}

Outcome<Response> list(Studies& studies, const Request& request, const Principal& who) {
  const auto limit = integer_in_query(request, "limit", 50, 1, kMostListed);
  DIAPHANE_TRY(limit);
  const auto after = cursor_in_query(request);
  DIAPHANE_TRY(after);
  const auto page = studies.list(who, *after, *limit);
  DIAPHANE_TRY(page);
  ordered_json body{{"items", ordered_json::array()}, {"next_cursor", nullptr}};
  for (const Study& one : page->items) body["items"].push_back(to_json(one));
  if (page->next) body["next_cursor"] = encode_cursor(*page->next);
  return json_response(200, body);
}

Outcome<Response> create(Studies& studies, const Clock& clock, const Request& request,
                         const Principal& who) {
  const auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  Fields in(request, kMostStudyValues);
  StudyContent content = read_definition(in, clock.wall());
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto made = studies.create(who, std::move(content), *key);
  DIAPHANE_TRY(made);
  return with_definition(201, *made).with("Location", "/v1/studies/" + made->id);
}

Outcome<Response> replace(Studies& studies, const Clock& clock, const Request& request,
                          const Principal& who) {
  Fields in(request, kMostStudyValues);
  const StudyContent content = read_definition(in, clock.wall());
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  DIAPHANE_TRY(studies.find(who, request.parameter("study_id")));
  const auto version = version_in_if_match(request);
  DIAPHANE_TRY(version);
  return answer_study(studies.replace(who, request.parameter("study_id"), *version, content));
}

Outcome<Response> set_state(Studies& studies, const Request& request, const Principal& who) {
  Fields in(request);
  const std::string state = in.choice("state", kStates);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return answer_study(studies.set_state(who, request.parameter("study_id"), study_state_of(state)));
}

Outcome<Response> preview(Participations& participations, const Request& request,
                          const Principal& who) {
  Fields in(request);
  const std::string key = in.text("key", 64, 64);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto joined = participations.preview(who, request.parameter("study_id"), key);
  DIAPHANE_TRY(joined);
  return joined_response(*joined);
}

/// Sends a file of the cache directory. The edge sends it, because a response is at most 1 MB.
Response file_response(const Studies::File& file) {
  Response response;
  response.content_type = file.content_type;
  return std::move(response)
      .with("X-Accel-Redirect", "/_cache/" + file.name)
      .with("Cache-Control", "no-store");
}

Outcome<Response> make_export(Studies& studies, const Request& request, const Principal& who) {
  const auto format = choice_in_query(request, "format", kFormats);
  DIAPHANE_TRY(format);
  const auto file = studies.make_export(who, request.parameter("study_id"), *format);
  DIAPHANE_TRY(file);
  const std::string ending = *format == "csv" ? "zip" : "json";
  return file_response(*file).with("Content-Disposition",
                                   "attachment; filename=\"diaphane-study." + ending + "\"");
}

Outcome<Response> analyse(Studies& studies, const Request& request, const Principal& who) {
  const auto language = choice_in_query(request, "language", kLanguages);
  DIAPHANE_TRY(language);
  const auto file =
      studies.analyse(who, request.parameter("study_id"), language->empty() ? "en" : *language);
  DIAPHANE_TRY(file);
  return file_response(*file);
}

std::vector<Route> picture_routes(Studies& studies) {
  const auto put = [&studies](const Request& request, const Principal& who) {
    return answer(studies.put_picture(who, request.parameter("study_id"),
                                      request.parameter("picture_id"), request.body));
  };
  const auto get = [&studies](const Request& request, const Principal& who) -> Outcome<Response> {
    auto found =
        studies.picture(who, request.parameter("study_id"), request.parameter("picture_id"));
    DIAPHANE_TRY(found);
    Response response;
    response.content_type = found->type;
    response.body = std::move(found->bytes);
    return response;
  };
  const std::string one = "/v1/studies/{study_id}/pictures/{picture_id}";
  return {
      {"PUT", one, "putStudyPicture", Access::kResearcher, put, {}, kMostPictureUpload},
      {"GET", one, "getStudyPicture", Access::kResearcher, get, {}},
  };
}

std::vector<Route> comfort_routes(Studies& studies) {
  const auto adopt = [&studies](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const bool comfort = in.boolean("comfort");
    if (!comfort) in.wrong("comfort", "must be true");
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(studies.adopt_comfort(who, request.parameter("study_id")));
  };
  const auto reset = [&studies](const Request&, const Principal& who) {
    return answer(studies.reset_comfort(who));
  };
  const auto get = [&studies](const Request&, const Principal&) -> Outcome<Response> {
    const auto comfort = studies.comfort();
    DIAPHANE_TRY(comfort);
    return json_response(200, {{"comfort", comfort->empty() ? ordered_json(nullptr)
                                                            : ordered_json::parse(*comfort)}});
  };
  return {
      {"POST",
       "/v1/studies/{study_id}/adoption",
       "adoptStudyResults",
       Access::kAdministrator,
       adopt,
       {}},
      {"DELETE", "/v1/perception/comfort", "resetComfort", Access::kAdministrator, reset, {}},
      {"GET", "/v1/perception", "getPerception", Access::kAnyone, get, {}},
  };
}

}  // namespace

std::vector<Route> study_routes(Studies& studies, Participations& participations,
                                const Clock& clock) {
  const auto list_all = [&studies](const Request& request, const Principal& who) {
    return list(studies, request, who);
  };
  const auto make = [&studies, &clock](const Request& request, const Principal& who) {
    return create(studies, clock, request, who);
  };
  const auto get = [&studies](const Request& request, const Principal& who) {
    return answer_study(studies.find(who, request.parameter("study_id")));
  };
  const auto put = [&studies, &clock](const Request& request, const Principal& who) {
    return replace(studies, clock, request, who);
  };
  const auto remove = [&studies](const Request& request, const Principal& who) {
    return answer(studies.remove(who, request.parameter("study_id")));
  };
  const auto state = [&studies](const Request& request, const Principal& who) {
    return set_state(studies, request, who);
  };
  const auto link = [&studies](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto token = studies.make_link(who, request.parameter("study_id"));
    DIAPHANE_TRY(token);
    return json_response(200, {{"path", "/study#" + *token}});
  };
  const auto look = [&participations](const Request& request, const Principal& who) {
    return preview(participations, request, who);
  };
  const auto export_it = [&studies](const Request& request, const Principal& who) {
    return make_export(studies, request, who);
  };
  const auto results = [&studies](const Request& request, const Principal& who) {
    return analyse(studies, request, who);
  };
  const std::string all = "/v1/studies", one = all + "/{study_id}";
  constexpr Access kWho = Access::kResearcher;
  return join({{
                   {"GET", all, "listStudies", kWho, list_all, {"limit", "cursor"}},
                   {"POST", all, "createStudy", kWho, make, {}},
                   {"GET", one, "getStudy", kWho, get, {}},
                   {"PUT", one, "replaceStudy", kWho, put, {}},
                   {"DELETE", one, "deleteStudy", kWho, remove, {}},
                   {"POST", one + "/state", "setStudyState", kWho, state, {}},
                   {"POST", one + "/link", "makeStudyLink", kWho, link, {}},
                   {"POST", one + "/preview", "previewStudy", kWho, look, {}},
                   {"GET", one + "/export", "exportStudy", kWho, export_it, {"format"}},
                   {"GET", one + "/analysis", "analyseStudy", kWho, results, {"language"}},
               },
               picture_routes(studies),
               comfort_routes(studies)});
}

}  // namespace diaphane::api
