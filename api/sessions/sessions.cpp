#include "api/sessions/sessions.h"

#include <algorithm>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_session() {
  return refuse(ProblemKind::kNotFound, "Session not found.");
}

/// The enumerators in use are in the order of their permissions, most first.
static_assert(SessionViewer::kOwner < SessionViewer::kShared &&
              SessionViewer::kShared < SessionViewer::kPublic);

SessionViewer viewer_of(Role role) {
  switch (role) {
    case Role::kOwner:
      return SessionViewer::kOwner;
    case Role::kSharedView:
    case Role::kSharedEdit:
      return SessionViewer::kShared;
    default:
      return SessionViewer::kPublic;
  }
}

bool lacks(const Permissions& now, const Permissions& before) {
  return (before.slices && !now.slices) || (before.downloads && !now.downloads);
}

tl::unexpected<Problem> permissions_changed() {
  return refuse(ProblemKind::kBusy,
                "The owner of this scan has just changed your permissions. Try again.",
                std::chrono::seconds(1));
}

}  // namespace

Outcome<Sessions::Shown> Sessions::find_shown(const Principal& who, const std::string& data_set_id,
                                              const std::string& over) {
  Shown shown;
  for (const std::string& id : {data_set_id, over}) {
    if (id.empty()) continue;
    auto found = data_sets_.find_ready(who, id);
    if (!found) return tl::unexpected(found.error());
    shown.push_back(*std::move(found));
  }
  return shown;
}

Outcome<void> Sessions::check_and_note(const Principal& who, const std::string& session_id,
                                       const Shown& shown) {
  // Access may have been revoked during the placement by a request that did not see this session.
  for (const DataSet& data_set : shown) {
    const auto still = data_sets_.find_ready(who, data_set.id);
    const bool withdrawn = still && lacks(still->allowed(), data_set.allowed());
    if (!still || withdrawn) (void)placement_.end(session_id);
    if (!still) return tl::unexpected(still.error());
    if (withdrawn) return permissions_changed();
  }
  for (const DataSet& data_set : shown) {
    // Views of a sample are not recorded, because it is public and has no owner.
    if (data_set.is_sample) continue;
    const View view{route_of(who, data_set), who.user_id, "", who.client};
    DIAPHANE_TRY(data_sets_.note_view(data_set.id, view));
  }
  return {};
}

Outcome<Sessions::Stream> Sessions::place(const Principal& who, const std::string& session_id,
                                          const Shown& shown, const std::string& to_first) {
  PlaceRequest request{session_id, who.user_id, shown.front().id};
  request.first_scene = first_scene_(request.data_set_id);
  // Of two data sets, the viewer may do only what both allow.
  request.viewer = SessionViewer::kOwner;
  request.slices = request.downloads = true;
  for (const DataSet& data_set : shown) {
    request.viewer = std::max(request.viewer, viewer_of(data_set.role));
    request.slices = request.slices && data_set.allowed().slices;
    request.downloads = request.downloads && data_set.allowed().downloads;
  }
  if (shown.size() > 1) request.over = shown.back().id;
  request.to_first = to_first;
  request.browser = who.session_id;
  const auto placed = placement_.place(request);
  if (placed) {
    DIAPHANE_TRY(check_and_note(who, session_id, shown));
    return Stream{session_id, "/stream?ticket=" + placed->ticket};
  }
  switch (placed.error().code) {
    case ErrorCode::kNotFound:
      return no_such_session();
    case ErrorCode::kUnauthenticated:
      return refuse(ProblemKind::kUnauthenticated, placed.error().message);
    case ErrorCode::kUnavailable:
      if (!placement_.reachable()) return refuse(placed.error());  // not the workers' fault
      return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
    default:
      return refuse(placed.error());
  }
}

Outcome<Sessions::Stream> Sessions::open(const Principal& who, const std::string& data_set_id,
                                         const std::string& over,
                                         const std::string& idempotency_key) {
  const auto shown = find_shown(who, data_set_id, over);
  DIAPHANE_TRY(shown);
  std::string to_first;
  if (!over.empty()) {
    auto motion = motion_(who, data_set_id, over);
    if (!motion) return tl::unexpected(motion.error());
    to_first = *std::move(motion);
  }
  DIAPHANE_TRY(render_time_.may_open(who));
  if (idempotency_key.empty()) return place(who, new_id(), *shown, to_first);

  // The key determines the session's ID, and placing the same ID again is idempotent.
  const std::string id = id_from("session\n" + who.user_id + "\n" + idempotency_key);
  const auto known = placement_.find(id);
  if (known && (known->data_set_id != data_set_id || known->over != over)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  if (!known && known.error().code != ErrorCode::kNotFound) return refuse(known.error());
  return place(who, id, *shown, to_first);
}

Outcome<std::vector<SessionInfo>> Sessions::list(const Principal& who) {
  auto found = placement_.sessions_of(who.user_id);
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<SessionInfo> Sessions::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_session();
  auto found = placement_.find(id);
  if (!found && found.error().code == ErrorCode::kNotFound) return no_such_session();
  if (!found) return refuse(found.error());
  if (found->user_id != who.user_id) return no_such_session();
  return *std::move(found);
}

Outcome<void> Sessions::end(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(find(who, id));
  if (auto done = placement_.end(id); !done) return refuse(done.error());
  return {};
}

Outcome<Sessions::Stream> Sessions::ticket(const Principal& who, const std::string& id) {
  const auto session = find(who, id);
  DIAPHANE_TRY(session);
  // The data set may have been deleted or made private since the session was opened.
  const auto shown = find_shown(who, session->data_set_id, session->over);
  if (!shown) {
    if (shown.error().kind == ProblemKind::kNotFound) return no_such_session();
    return tl::unexpected(shown.error());
  }
  DIAPHANE_TRY(render_time_.may_go_on(who));
  return place(who, id, *shown, {});
}

Outcome<ErrorCurve> Sessions::error_curve(const Principal& who, const std::string& id) {
  const auto session = find(who, id);
  DIAPHANE_TRY(session);
  auto curve = error_curves_.find(session->worker_id, id);
  // The worker does not know the session before its first viewer connects.
  if (!curve && curve.error().code == ErrorCode::kNotFound) return ErrorCurve{};
  if (!curve) return refuse(curve.error());
  return *std::move(curve);
}

}  // namespace diaphane::api
