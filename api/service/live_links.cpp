#include "api/service/live_links.h"

#include "api/service/secrets.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

constexpr std::chrono::minutes kJoinWindow{15};

tl::unexpected<Problem> no_such_session() {
  return refuse(ProblemKind::kNotFound, "There is no such session.");
}

tl::unexpected<Problem> no_such_link() {
  return refuse(ProblemKind::kNotFound, "This link was ended, or never was one.");
}

}  // namespace

Outcome<std::string> LiveLinks::check_owner(const Principal& who, const std::string& session_id) {
  if (!is_id(session_id)) return no_such_session();
  const auto session = placement_.find(session_id);
  if (!session && session.error().code != ErrorCode::kNotFound) return refuse(session.error());
  if (!session || session->user_id != who.user_id) return no_such_session();
  return session->data_set_id;
}

Outcome<std::string> LiveLinks::make(const Principal& who, const std::string& session_id,
                                     const Once& once) {
  const auto mine = check_owner(who, session_id);
  if (!mine) return tl::unexpected(mine.error());
  // With whom a scan is shared does not share it further.
  if (auto may = data_sets_.authorise(who, *mine, Action::kInvite); !may) {
    return tl::unexpected(may.error());
  }
  std::string token = token_for("live link\n" + session_id, once);
  const auto made = links_.make(session_id, who.user_id, blake2b(token));
  if (!made && made.error().code == ErrorCode::kNotFound) return no_such_session();
  if (!made && made.error().code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kConflict, "What this key made was ended. Make another link.");
  }
  if (!made) return refuse(made.error());
  return token;
}

Outcome<void> LiveLinks::end(const Principal& who, const std::string& session_id) {
  if (auto mine = check_owner(who, session_id); !mine) return tl::unexpected(mine.error());
  if (auto done = links_.end_links(session_id); !done) return refuse(done.error());
  return {};
}

Outcome<LiveLinks::Joined> LiveLinks::join(const std::string& token, const std::string& key,
                                           const std::string& name, const std::string& address) {
  if (!is_token(token)) return no_such_link();
  const std::string hash = blake2b(token);
  const auto session = links_.follow(hash);
  if (!session && session.error().code == ErrorCode::kNotFound) return no_such_link();
  if (!session) return refuse(session.error());
  const auto wait =
      accounts_.note_attempt({{blake2b("join:" + address), options_.by_address, kJoinWindow},
                              {blake2b("join link:" + hash), options_.by_link, kJoinWindow}},
                             clock_.wall());
  if (!wait) return refuse(wait.error());
  if (*wait) {
    return refuse(ProblemKind::kTooManyAttempts,
                  "Many people join from where you are. Try again in a while.", **wait);
  }
  // The owner may have lost the data set since: then nobody sees it any more.
  Principal owner;
  owner.user_id = session->user_id;
  if (!data_sets_.find_ready(owner, session->data_set_id)) return no_such_link();

  const std::string participant = id_from("participant\n" + session->id + "\n" + key);
  PlaceRequest request{session->id, session->user_id, session->data_set_id, participant, name,
                       hash};
  // Where the owner has gone and the session holds no slot any more, its guests need one
  // themselves.
  request.visitor = true;
  request.visitor_from = hash;
  const auto placed = placement_.place(request);
  if (!placed && placed.error().code == ErrorCode::kTooLarge) {
    return refuse(ProblemKind::kBusy,
                  "All places for visitors are taken. Try again in a few minutes, or when the "
                  "person who shared the link is back.",
                  std::chrono::seconds(30));
  }
  if (placed) return Joined{participant, "/stream?ticket=" + placed->ticket};
  if (placed.error().code == ErrorCode::kNotFound) return no_such_link();
  if (placed.error().code == ErrorCode::kUnavailable && placement_.reachable()) {
    return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
  }
  return refuse(placed.error());
}

}  // namespace diaphane::api
