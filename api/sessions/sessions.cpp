#include "api/sessions/sessions.h"

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_session() {
  return refuse(ProblemKind::kNotFound, "Session not found.");
}

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

Outcome<Sessions::Stream> Sessions::place(const Principal& who, const std::string& session_id,
                                          const DataSet& data_set) {
  PlaceRequest request{session_id, who.user_id, data_set.id};
  request.first_scene = first_scene_(data_set.id);
  request.viewer = viewer_of(data_set.role);
  const Permissions allowed = data_set.allowed();
  request.slices = allowed.slices;
  request.downloads = allowed.downloads;
  request.browser = who.session_id;
  const auto placed = placement_.place(request);
  if (placed) {
    // Access may have been revoked during the placement by a request that did not see this session.
    const auto still = data_sets_.find_ready(who, data_set.id);
    if (!still || lacks(still->allowed(), allowed)) (void)placement_.end(session_id);
    if (!still) return tl::unexpected(still.error());
    if (lacks(still->allowed(), allowed)) return permissions_changed();
    // Views of a sample are not recorded, because it is public and has no owner.
    if (!data_set.is_sample) {
      const View view{route_of(who, data_set), who.user_id, "", who.client};
      DIAPHANE_TRY(data_sets_.note_view(data_set.id, view));
    }
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
                                         const std::string& idempotency_key) {
  const auto data_set = data_sets_.find_ready(who, data_set_id);
  DIAPHANE_TRY(data_set);
  DIAPHANE_TRY(render_time_.may_open(who));
  if (idempotency_key.empty()) return place(who, new_id(), *data_set);

  // The key determines the session's ID, and placing the same ID again is idempotent.
  const std::string id = id_from("session\n" + who.user_id + "\n" + idempotency_key);
  const auto known = placement_.find(id);
  if (known && known->data_set_id != data_set_id) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  if (!known && known.error().code != ErrorCode::kNotFound) return refuse(known.error());
  return place(who, id, *data_set);
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
  const auto data_set = data_sets_.find_ready(who, session->data_set_id);
  if (!data_set) {
    if (data_set.error().kind == ProblemKind::kNotFound) return no_such_session();
    return tl::unexpected(data_set.error());
  }
  DIAPHANE_TRY(render_time_.may_go_on(who));
  return place(who, id, *data_set);
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
