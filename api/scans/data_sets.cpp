#include "api/scans/data_sets.h"

#include <array>
#include <utility>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::array<std::pair<DataSetState, std::string_view>, 6> kStates{{
    {DataSetState::kUploading, "uploading"},
    {DataSetState::kQueued, "queued"},
    {DataSetState::kBuilding, "building"},
    {DataSetState::kReady, "ready"},
    {DataSetState::kRefused, "refused"},
    {DataSetState::kExpired, "expired"},
}};

tl::unexpected<Problem> not_found() { return refuse(ProblemKind::kNotFound, "Scan not found."); }

Viewer viewer_of(const Principal& who) {
  return {who.user_id, who.sample_operator, who.administrator};
}

tl::unexpected<Problem> too_many(const TooManyDataSets& many, const DataSetLimits& limits) {
  if (many.unprocessed) {
    return refuse(ProblemKind::kTooMany,
                  std::to_string(limits.unprocessed) +
                      " of your scans are still being uploaded or processed. Wait until some of "
                      "them are ready, then try again.",
                  std::chrono::minutes(1));
  }
  return refuse(ProblemKind::kTooManyDataSets,
                "You have " + std::to_string(limits.all) +
                    " scans, which is the limit. Delete some of them, then try again.");
}

Cursor cursor_at(Time time, const std::string& id) {
  return {std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count(),
          id};
}

std::string in_megabytes(std::int64_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; }

}  // namespace

std::string_view to_string(DataSetState state) {
  for (const auto& [value, text] : kStates) {
    if (value == state) return text;
  }
  return "expired";
}

DataSetState data_set_state_of(std::string_view text) {
  for (const auto& [value, name] : kStates) {
    if (name == text) return value;
  }
  return DataSetState::kExpired;
}

DataSets::DataSets(DataSetStore& store, Placement& placement, const Clock& clock,
                   const Signals& signals, Options options,
                   std::function<std::int64_t()> free_bytes)
    : store_(store),
      placement_(placement),
      clock_(clock),
      signals_(signals),
      options_(options),
      free_bytes_(std::move(free_bytes)) {}

Outcome<DataSet> DataSets::announce(const Principal& who, const Announcement& announcement) {
  if (announcement.bytes > options_.max_upload_bytes) {
    return refuse(ProblemKind::kUploadTooLarge,
                  "The maximum upload size is " + in_megabytes(options_.max_upload_bytes) + ".");
  }
  if (free_bytes_() - options_.reserve_bytes < announcement.bytes) {
    return refuse(ProblemKind::kStorageFull,
                  "The server's storage is full at the moment. Try again later.",
                  std::chrono::minutes(10));
  }
  const auto now = clock_.wall();
  const Owner owner{who.user_id};
  std::optional<IdempotencyKey> key;
  if (!announcement.idempotency_key.empty() && !who.sample_operator) {
    key = IdempotencyKey{"createDataSet", announcement.idempotency_key,
                         blake2b(std::to_string(announcement.bytes) + "\n" + announcement.title)};
  }
  const auto made = store_.create(
      {new_id(), owner, announcement.title, announcement.bytes, now + options_.upload_life},
      options_.limits, key, now);
  if (!made) return refuse(made.error());
  if (const auto* over = std::get_if<OverQuota>(&*made)) {
    return refuse(ProblemKind::kOverQuota,
                  "This scan needs " + in_megabytes(announcement.bytes) + ", but " +
                      in_megabytes(over->quota.used) + " of your " +
                      in_megabytes(over->quota.bytes) +
                      " of storage are already in use. Delete other scans first.");
  }
  if (const auto* many = std::get_if<TooManyDataSets>(&*made)) {
    return too_many(*many, options_.limits);
  }
  if (std::holds_alternative<KeyReused>(*made)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  auto found = store_.find(viewer_of(who), std::get<Created>(*made).id);
  if (!found && found.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kConflict,
                  "The resource created with this Idempotency-Key has since been deleted.");
  }
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<DataSets::Page> DataSets::list(const Principal& who, std::optional<Cursor> after,
                                       int limit) {
  // Reads one extra entry to find out whether there is a next page.
  auto found = store_.list(viewer_of(who), std::move(after), limit + 1);
  if (!found) return refuse(found.error());
  Page page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    page.next = cursor_at(page.items.back().created_at, page.items.back().id);
  }
  return page;
}

Outcome<DataSet> DataSets::authorise(const Principal& who, const std::string& id, Action action) {
  if (!is_id(id)) return not_found();
  auto found = store_.find(viewer_of(who), id);
  if (!found && found.error().code == ErrorCode::kNotFound) return not_found();
  if (!found) return refuse(found.error());
  const DataSetRelation relation{found->role, who.administrator};
  if (!may(relation, Action::kFind, found->exposure())) return not_found();
  if (!may(relation, action, found->exposure())) {
    return refuse(ProblemKind::kForbidden,
                  "You can view this scan, but you don't have permission to do this.");
  }
  return *std::move(found);
}

Outcome<DataSet> DataSets::find(const Principal& who, const std::string& id) {
  return authorise(who, id, Action::kFind);
}

Outcome<DataSet> DataSets::find_ready(const Principal& who, const std::string& id) {
  auto found = authorise(who, id, Action::kLook);
  if (found && found->state != DataSetState::kReady) {
    return refuse(ProblemKind::kNotReady, "This scan is not ready yet. Its state is " +
                                              std::string(to_string(found->state)) + ".");
  }
  return found;
}

Outcome<DataSet> DataSets::describe(const Principal& who, const std::string& id,
                                    const Description& what) {
  if (auto found = authorise(who, id, Action::kDescribe); !found) return found;
  const auto done = store_.describe(id, what, clock_.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return not_found();
  if (!done) return refuse(done.error());
  return find(who, id);
}

Outcome<void> DataSets::remove(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(authorise(who, id, Action::kDelete));
  const auto done = store_.remove({who.user_id}, id, clock_.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return not_found();
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kDisposal);
  // The rows are deleted, so the data set can no longer be opened. Its sessions are ended if
  // possible.
  if (const auto ended = placement_.end_all_of(id); !ended) {
    log::warning("failed to end the sessions of a deleted scan", {{"data_set", id}});
  }
  return {};
}

ViewRoute route_of(const Principal& who, const DataSet& data_set) {
  switch (data_set.role) {
    case Role::kOwner:
      return ViewRoute::kOwner;
    case Role::kSharedView:
    case Role::kSharedEdit:
      return ViewRoute::kPerson;
    default:
      return who.administrator ? ViewRoute::kAdministrator : ViewRoute::kGallery;
  }
}

Outcome<void> DataSets::note_picture(const Principal& who, const DataSet& data_set) {
  if (data_set.owned() || data_set.is_public) return {};
  const ViewRoute route = route_of(who, data_set);
  const auto actor =
      route == ViewRoute::kAdministrator ? AuditActor::kAdministrator : AuditActor::kPerson;
  return note_access({actor,
                      who.user_id,
                      "data-set.picture-looked-at",
                      "data_set",
                      data_set.id,
                      {{"by", std::string(to_string(route))}}});
}

Outcome<void> DataSets::note_linked_picture(const DataSet& data_set, const std::string& link_id) {
  if (data_set.is_public) return {};
  return note_access({AuditActor::kPerson,
                      "",
                      "data-set.picture-looked-at",
                      "data_set",
                      data_set.id,
                      {{"by", std::string(to_string(ViewRoute::kLink))}, {"link", link_id}}});
}

Outcome<void> DataSets::note_access(const AuditEntry& entry) {
  const auto now = clock_.wall();
  const auto done = store_.note_access(entry, now - kSameView, now);
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> DataSets::note_view(const std::string& id, const View& view) {
  AuditEntry entry{AuditActor::kPerson,
                   view.by_account() ? view.viewer : "",
                   "data-set.looked-at",
                   "data_set",
                   id,
                   {{"by", std::string(to_string(view.route))}}};
  if (view.route == ViewRoute::kAdministrator) entry.actor = AuditActor::kAdministrator;
  if (!view.link_id.empty()) entry.details.emplace_back("link", view.link_id);
  const auto done = store_.note_view(view, entry, clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> DataSets::note_export_downloaded(const Principal& who, const std::string& id,
                                               const std::string& format) {
  return note_access({AuditActor::kPerson,
                      who.user_id,
                      "data-set.export-downloaded",
                      "data_set",
                      id,
                      {{"format", format}}});
}

Outcome<ViewPage> DataSets::views(const Principal& who, const std::string& id, ViewQuery query) {
  DIAPHANE_TRY(authorise(who, id, Action::kReadViews));
  const int limit = query.limit++;
  auto found = store_.views(id, query);
  if (!found) return refuse(found.error());
  ViewPage page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    page.next = cursor_at(page.items.back().last_at, page.items.back().id);
  }
  return page;
}

Outcome<void> DataSets::note_live_links(const Principal& who, const std::string& id,
                                        const std::string& action,
                                        std::vector<AuditDetail> details) {
  const auto now = clock_.wall();
  const auto done = store_.note_access(
      {AuditActor::kPerson, who.user_id, action, "data_set", id, std::move(details)}, now, now);
  if (!done) return refuse(done.error());
  return {};
}

}  // namespace diaphane::api
