#include "api/studies/studies.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

using nlohmann::json;

/// Farther than this, no camera shows anything of a scan.
constexpr double kMostMillimetres = 100'000;

tl::unexpected<Problem> study_problem(const Error& error) {
  if (error.code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kNotFound, "Study not found.");
  }
  if (error.code == ErrorCode::kConflict && error.field == "version") {
    return refuse(ProblemKind::kPrecondition, error.message);
  }
  return refuse(error);
}

std::set<std::string> pictures_in(const json& definition) {
  std::set<std::string> ids;
  for (const json& step : definition["steps"]) {
    if (!step.contains("pictures")) continue;
    for (const json& one : step["pictures"]) ids.insert(one["id"].get<std::string>());
  }
  return ids;
}

/// Returns a member of a document from another service, or null if it has none.
json member(const json& of, const char* name) {
  return of.is_object() ? of.value(name, json()) : json();
}

/// Whether this is a difference between two RGB colours, of 255 as in the analysis and the page.
bool is_difference(const json& value) {
  return value.is_array() && value.size() == 3 && std::ranges::all_of(value, [](const json& one) {
           return one.is_number() && std::abs(one.get<double>()) <= 255;
         });
}

/// Whether this is a place or a direction in millimetres, within what the renderer accepts.
bool is_vector(const json& value) {
  return value.is_array() && value.size() == 3 && std::ranges::all_of(value, [](const json& one) {
           return one.is_number() && std::abs(one.get<double>()) <= kMostMillimetres;
         });
}

bool is_view(const json& view) {
  const json eye = member(view, "eye"), target = member(view, "target"), up = member(view, "up");
  const json none{0, 0, 0};
  return is_vector(eye) && is_vector(target) && is_vector(up) && eye != target && up != none;
}

/// Returns the views of the tour that an analysis gives for a step and a data set. Empty if there
/// are none, or they can't be used.
json views_of_tour(const json& analysis, const std::string& step, const std::string& data_set_id) {
  for (const json& one : member(member(analysis, "adoptable"), "tours")) {
    if (member(one, "step") != step || member(one, "data_set_id") != data_set_id) continue;
    const json views = member(one, "views");
    if (!views.is_array() || !std::ranges::all_of(views, is_view)) break;
    json plain = json::array();
    for (const json& view : views) {
      plain.push_back({{"eye", view["eye"]}, {"target", view["target"]}, {"up", view["up"]}});
    }
    return plain;
  }
  return json::array();
}

/// Calls a function when it goes out of scope, also because of an exception.
template <typename Function>
class AtExit {
 public:
  explicit AtExit(Function function) : function_(std::move(function)) {}
  ~AtExit() { function_(); }
  AtExit(const AtExit&) = delete;
  AtExit& operator=(const AtExit&) = delete;

 private:
  Function function_;
};

}  // namespace

std::string_view to_string(StudyState state) {
  switch (state) {
    case StudyState::kDraft:
      return "draft";
    case StudyState::kOpen:
      return "open";
    case StudyState::kClosed:
      break;
  }
  return "closed";
}

StudyState study_state_of(std::string_view text) {
  if (text == "draft") return StudyState::kDraft;
  return text == "open" ? StudyState::kOpen : StudyState::kClosed;
}

Outcome<DataSet> find_for_study(DataSets& data_sets, const std::string& owner_id,
                                const std::string& id) {
  Principal researcher;
  researcher.user_id = owner_id;
  auto found = data_sets.find_ready(researcher, id);
  DIAPHANE_TRY(found);
  if (found->owned() || found->is_public) return found;
  return refuse(ProblemKind::kForbidden,
                "A study can show only your own scans, public scans and samples.");
}

Outcome<Study> Studies::create(const Principal& who, StudyContent content, const std::string& key) {
  Study study;
  study.id = new_id();
  study.owner_id = who.user_id;
  study.content = std::move(content);
  study.created_at = clock_.wall();
  std::optional<IdempotencyKey> once;
  if (!key.empty()) once = IdempotencyKey{"createStudy", key, blake2b(study.content.definition)};
  const auto made = store_.create(study, kMostStudies, once);
  if (!made) return refuse(made.error());
  if (std::holds_alternative<KeyReused>(*made)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  return find(who, std::get<Created>(*made).id);
}

Outcome<Studies::Page> Studies::list(const Principal& who, const std::optional<Cursor>& after,
                                     int limit) {
  auto found = store_.of(who.user_id, after, limit + 1, clock_.wall());
  if (!found) return refuse(found.error());
  Page page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    const Study& last = page.items.back();
    page.next = Cursor{
        std::chrono::duration_cast<std::chrono::microseconds>(last.created_at.time_since_epoch())
            .count(),
        last.id};
  }
  return page;
}

Outcome<Study> Studies::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return refuse(ProblemKind::kNotFound, "Study not found.");
  auto found = store_.find(who.user_id, id, clock_.wall());
  if (!found) return study_problem(found.error());
  return *std::move(found);
}

Outcome<Study> Studies::replace(const Principal& who, const std::string& id, int version,
                                const StudyContent& content) {
  DIAPHANE_TRY(find(who, id));
  const auto sessions = store_.replace(who.user_id, id, version,
                                       pictures_in(json::parse(content.definition)), content);
  if (!sessions) return study_problem(sessions.error());
  end(*sessions);
  return find(who, id);
}

Outcome<void> Studies::remove(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(find(who, id));
  const auto sessions = store_.remove(who.user_id, id, clock_.wall());
  if (!sessions) return study_problem(sessions.error());
  end(*sessions);
  return {};
}

void Studies::end(const StudyStore::SessionIds& sessions) {
  for (const std::string& session : sessions) {
    // The store keeps the session, so that the background task tries again if Redis is unavailable.
    if (placement_.end(session)) {
      (void)store_.forget_session(session);
    } else {
      log::warning("failed to end the session of a study");
    }
  }
}

Outcome<void> Studies::check_scans_and_pictures(const Principal& who, const Study& study) {
  const json definition = json::parse(study.content.definition);
  const auto stored = store_.pictures(study.id);
  if (!stored) return refuse(stored.error());
  for (const std::string& one : pictures_in(definition)) {
    if (std::ranges::find(*stored, one) == stored->end()) {
      return refuse(ProblemKind::kConflict, "The picture " + one + " is missing. Add it first.");
    }
  }
  std::set<std::string> scans;
  for (const json& step : definition["steps"]) {
    if (step.contains("view")) scans.insert(step["view"]["data_set_id"].get<std::string>());
  }
  for (const std::string& one : scans) {
    const auto found = find_for_study(data_sets_, who.user_id, one);
    if (found) continue;
    const ProblemKind kind = found.error().kind;
    if (kind == ProblemKind::kNotFound || kind == ProblemKind::kNotReady ||
        kind == ProblemKind::kForbidden) {
      return refuse(ProblemKind::kConflict,
                    "A scan of this study can't be used. A study can show your own scans, public "
                    "scans and samples.");
    }
    return tl::unexpected(found.error());
  }
  return {};
}

Outcome<Study> Studies::set_state(const Principal& who, const std::string& id, StudyState state) {
  const auto study = find(who, id);
  DIAPHANE_TRY(study);
  const auto now = clock_.wall();
  if (state == StudyState::kOpen) {
    if (study->content.ends_at <= now) {
      return refuse(ProblemKind::kConflict,
                    "The end of this study has passed. Choose a later one.");
    }
    DIAPHANE_TRY(check_scans_and_pictures(who, *study));
  }
  const auto sessions = store_.set_state(who.user_id, id, study->version, state, now);
  if (!sessions) return study_problem(sessions.error());
  end(*sessions);
  return find(who, id);
}

Outcome<std::string> Studies::make_link(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(find(who, id));
  std::string token = random_hex(32);
  const auto done = store_.set_link(who.user_id, id, blake2b(token));
  if (!done) return study_problem(done.error());
  return token;
}

Outcome<void> Studies::put_picture(const Principal& who, const std::string& id,
                                   const std::string& picture_id, const std::string& file) {
  const auto study = find(who, id);
  DIAPHANE_TRY(study);
  if (!pictures_in(json::parse(study->content.definition)).contains(picture_id)) {
    return refuse(ProblemKind::kNotFound, "The study has no picture with this ID.");
  }
  auto checked = check_picture_(file);
  if (!checked) return refuse_field("picture", checked.error().message);
  const auto done =
      store_.put_picture(who.user_id, id, {picture_id, checked->type, std::move(checked->bytes)},
                         static_cast<int>(kMostStudyPictures));
  if (!done) return study_problem(done.error());
  return {};
}

Outcome<StudyPicture> Studies::picture(const Principal& who, const std::string& id,
                                       const std::string& picture_id) {
  DIAPHANE_TRY(find(who, id));
  auto found = store_.picture(id, picture_id);
  if (!found && found.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kNotFound, "Picture not found.");
  }
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<Studies::File> Studies::make_export(const Principal& who, const std::string& id,
                                            const std::string& format) {
  const auto study = find(who, id);
  DIAPHANE_TRY(study);
  const auto noted = store_.note_exported(who.user_id, id, clock_.wall());
  if (!noted) return refuse(noted.error());
  const bool csv = format == "csv";
  const auto name = csv ? exports_.write_zip(*study) : exports_.write_json(*study);
  if (!name) return refuse(name.error());
  return File{*name, csv ? "application/zip" : "application/json"};
}

Outcome<std::string> Studies::run_analysis(const Study& study, const std::string& language) {
  {
    const std::lock_guard lock(mutex_);
    if (analyses_ >= kMostAnalyses) {
      return refuse(ProblemKind::kBusy,
                    "Other results are being calculated. Try again in a moment.",
                    std::chrono::seconds(5));
    }
    ++analyses_;
  }
  const AtExit counted([&] {
    const std::lock_guard lock(mutex_);
    --analyses_;
  });
  const auto name = exports_.write_json(study);
  if (!name) return refuse(name.error());
  const AtExit removed([&] { exports_.remove(*name); });
  auto results = analysis_.analyse(exports_.path_of(*name), language);
  if (!results) return refuse(results.error());
  return *std::move(results);
}

Outcome<Studies::File> Studies::analyse(const Principal& who, const std::string& id,
                                        const std::string& language) {
  const auto study = find(who, id);
  DIAPHANE_TRY(study);
  const auto results = run_analysis(*study, language);
  DIAPHANE_TRY(results);
  const auto name = exports_.write_text(*results);
  if (!name) return refuse(name.error());
  return File{*name, "application/json"};
}

Outcome<void> Studies::adopt_comfort(const Principal& administrator, const std::string& id) {
  if (!is_id(id)) return refuse(ProblemKind::kNotFound, "Study not found.");
  const auto owner = store_.owner_of(id);
  if (!owner) return study_problem(owner.error());
  const auto study = store_.find(*owner, id, clock_.wall());
  if (!study) return study_problem(study.error());
  const auto results = run_analysis(*study, "en");
  DIAPHANE_TRY(results);
  const json read = json::parse(*results, nullptr, false);
  const json comfort = member(member(read, "adoptable"), "comfort");
  if (!is_difference(member(comfort, "bone")) || !is_difference(member(comfort, "blood"))) {
    return refuse(ProblemKind::kConflict, "The results of this study are not clear enough to use.");
  }
  const json adopted{{"bone", comfort["bone"]},
                     {"blood", comfort["blood"]},
                     {"participants", study->joined},
                     {"title", json::parse(study->content.title)}};
  const auto done = store_.set_comfort(administrator.user_id, id, adopted.dump(), clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> Studies::reset_comfort(const Principal& administrator) {
  const auto done = store_.set_comfort(administrator.user_id, "", "", clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<std::string> Studies::comfort() {
  auto found = store_.comfort();
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> Studies::adopt_tour(const Principal& who, const std::string& data_set_id,
                                  const std::string& study_id, const std::string& step) {
  const auto data_set = data_sets_.authorise(who, data_set_id, Action::kSetTour);
  DIAPHANE_TRY(data_set);
  const auto study = find(who, study_id);
  DIAPHANE_TRY(study);
  if (data_set->anonymised_at && study->opened_at && *data_set->anonymised_at > *study->opened_at) {
    return refuse(ProblemKind::kConflict,
                  "The scan was cut after the study opened, so that its views may not fit.");
  }
  const auto results = run_analysis(*study, "en");
  DIAPHANE_TRY(results);
  const json views = views_of_tour(json::parse(*results, nullptr, false), step, data_set_id);
  if (views.size() < 2 || views.size() > kMostTourViews) {
    return refuse(ProblemKind::kConflict, "The results of this study are not clear enough to use.");
  }
  const json tour{{"views", views},
                  {"participants", study->joined},
                  {"title", json::parse(study->content.title)}};
  const auto done = store_.set_tour(who.user_id, data_set_id, tour.dump(), clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> Studies::remove_tour(const Principal& who, const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kSetTour));
  const auto done = store_.set_tour(who.user_id, data_set_id, "", clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<Studies::Tour> Studies::tour(const Principal& who, const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kLook));
  auto found = tour_of(data_set_id);
  DIAPHANE_TRY(found);
  found->removable = data_sets_.authorise(who, data_set_id, Action::kSetTour).has_value();
  return found;
}

Outcome<Studies::Tour> Studies::tour_of(const std::string& data_set_id) {
  auto found = store_.tour(data_set_id);
  if (!found) return refuse(found.error());
  return Tour{*std::move(found)};
}

void Studies::expire() {
  exports_.expire();
  const auto over = store_.expire(clock_.wall());
  if (over) end(*over);
}

}  // namespace diaphane::api
