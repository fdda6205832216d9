#include "api/sharing/live_links.h"

#include <algorithm>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::chrono::minutes kJoinWindow{15};

tl::unexpected<Problem> no_own_session() {
  return refuse(ProblemKind::kNotFound, "Session not found.");
}

/// Returns the data sets that a session shows.
std::vector<std::string> shown_by(const SessionInfo& session) {
  if (session.over.empty()) return {session.data_set_id};
  return {session.data_set_id, session.over};
}

tl::unexpected<Problem> no_such_live_link() {
  return refuse(ProblemKind::kNotFound, "This link is invalid or has been disabled.");
}

}  // namespace

Outcome<SessionInfo> LiveLinks::check_owner(const Principal& who, const std::string& session_id) {
  if (!is_id(session_id)) return no_own_session();
  const auto session = placement_.find(session_id);
  if (!session && session.error().code != ErrorCode::kNotFound) return refuse(session.error());
  if (!session || session->user_id != who.user_id) return no_own_session();
  return *session;
}

Outcome<std::string> LiveLinks::make(const Principal& who, const std::string& session_id,
                                     bool slices, const IdempotencyScope& once) {
  const auto mine = check_owner(who, session_id);
  DIAPHANE_TRY(mine);
  // People with whom a scan is shared must not share it further.
  for (const std::string& id : shown_by(*mine)) {
    const auto data_set = data_sets_.authorise(who, id, Action::kInvite);
    if (!data_set && data_set.error().kind == ProblemKind::kForbidden && !mine->over.empty()) {
      return refuse(ProblemKind::kForbidden,
                    "You can invite others only if you may do so for both scans.");
    }
    DIAPHANE_TRY(data_set);
    if (slices && !data_set->allowed().slices) {
      return refuse_field("slices", "The owner of this scan has not shared its slices.");
    }
  }
  std::string token = token_for("live link\n" + session_id, once);
  const auto made = links_.make(session_id, who.user_id, blake2b(token), slices);
  if (!made && made.error().code == ErrorCode::kNotFound) return no_own_session();
  if (!made && made.error().code == ErrorCode::kConflict) {
    return refuse(
        ProblemKind::kConflict,
        "The link created with this Idempotency-Key has been disabled. Create a new link.");
  }
  if (!made && made.error().code == ErrorCode::kInvalid) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  if (!made) return refuse(made.error());
  for (const std::string& id : shown_by(*mine)) {
    DIAPHANE_TRY(data_sets_.note_live_links(who, id, "data-set.live-link-made",
                                            {{"slices", std::int64_t{slices}}}));
  }
  return token;
}

Outcome<void> LiveLinks::end(const Principal& who, const std::string& session_id) {
  const auto mine = check_owner(who, session_id);
  DIAPHANE_TRY(mine);
  if (auto done = links_.end_links(session_id); !done) return refuse(done.error());
  for (const std::string& id : shown_by(*mine)) {
    DIAPHANE_TRY(data_sets_.note_live_links(who, id, "data-set.live-links-ended"));
  }
  return {};
}

Outcome<std::vector<DataSet>> LiveLinks::find_shown(const SessionInfo& session) {
  // If the owner has lost access to a data set, guests must not see it either.
  Principal owner;
  owner.user_id = session.user_id;
  std::vector<DataSet> shown;
  for (const std::string& id : shown_by(session)) {
    auto data_set = data_sets_.find_ready(owner, id);
    if (!data_set) {
      const ProblemKind kind = data_set.error().kind;
      if (kind == ProblemKind::kNotFound || kind == ProblemKind::kNotReady)
        return no_such_live_link();
      return tl::unexpected(data_set.error());
    }
    shown.push_back(*std::move(data_set));
  }
  return shown;
}

Outcome<LiveLinks::Joined> LiveLinks::join(const std::string& token, const std::string& key,
                                           const std::string& name, const Client& client) {
  if (!is_token(token)) return no_such_live_link();
  const std::string hash = blake2b(token);
  const auto target = links_.follow(hash);
  if (!target && target.error().code == ErrorCode::kNotFound) return no_such_live_link();
  if (!target) return refuse(target.error());
  const SessionInfo* const session = &target->session;
  const auto wait =
      accounts_.note_attempt({{blake2b("join:" + client.address), options_.by_address, kJoinWindow},
                              {blake2b("join link:" + hash), options_.by_link, kJoinWindow}},
                             clock_.wall());
  if (!wait) return refuse(wait.error());
  if (*wait) {
    return refuse(ProblemKind::kTooManyAttempts,
                  "Too many people are joining from your network. Try again later.", **wait);
  }
  const auto shown = find_shown(*session);
  DIAPHANE_TRY(shown);

  const std::string participant = id_from("participant\n" + session->id + "\n" + key);
  PlaceRequest request{session->id, session->user_id, session->data_set_id, participant, name,
                       hash};
  request.slices =
      target->slices && std::all_of(shown->begin(), shown->end(),
                                    [](const DataSet& one) { return one.allowed().slices; });
  // If the owner has left and the session has lost its slot, the session takes a slot of the
  // visitors' share.
  request.visitor = true;
  request.visitor_from = hash;
  const auto placed = placement_.place(request);
  if (!placed && placed.error().code == ErrorCode::kTooLarge) {
    return refuse(ProblemKind::kBusy,
                  "All guest places are taken. Try again in a few minutes, or when the person who "
                  "shared the link is back.",
                  std::chrono::seconds(30));
  }
  if (placed) {
    for (const DataSet& data_set : *shown) {
      // Views of a sample are not recorded, because it is public and has no owner.
      if (data_set.is_sample) continue;
      const View view{ViewRoute::kLiveLink, participant, "", client};
      DIAPHANE_TRY(data_sets_.note_view(data_set.id, view));
    }
    return Joined{participant, "/stream?ticket=" + placed->ticket};
  }
  if (placed.error().code == ErrorCode::kNotFound) return no_such_live_link();
  if (placed.error().code == ErrorCode::kUnavailable && placement_.reachable()) {
    return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
  }
  return refuse(placed.error());
}

}  // namespace diaphane::api
