// A follower with a free camera gets a separate session beside the group's (docs/adr/0013).
#include <algorithm>

#include "renderd/serve/live_session.h"

namespace diaphane::render {

void LiveSession::silence() {
  const std::lock_guard lock(mutex_);
  links_.clear();
}

void LiveSession::dismiss() {
  silence();
  end({ErrorCode::kConflict, "The session is no longer needed.", {}});
  on_ended_({ErrorCode::kUnavailable, "The session has no viewers.", {}});
}

void LiveSession::follow(const v1::Scene& presenters) {
  {
    const std::lock_guard lock(mutex_);
    render::follow(state_, presenters, parts_.clock.now());
    publish_version();
  }
  parts_.runner.wake();
}

/// Returns false if the private session accepts no viewer. Then this one stays with the group's
/// picture and learns why.
bool LiveSession::enter_free_camera(std::uint64_t connection, Receiver& receiver,
                                    const std::shared_ptr<ClientLink>& link,
                                    const std::shared_ptr<LiveSession>& made) {
  const SessionStatus status = made->status();
  const auto there = made->attach(
      link, {receiver.participant, receiver.name, {}, receiver.viewer, receiver.may_have_slices},
      {status.placement, status.visitor});
  if (!there) {
    v1::ServerMessage message;
    *message.mutable_problem() = problem_of(there.error(), 0, false);
    send(connection, message);
    return false;
  }
  free_cameras_[connection] = {made, *there};
  use_free_camera(state_, receiver, true, parts_.clock.now());
  v1::ClientMessage greeting;
  *greeting.mutable_hello() = *receiver.hello;
  made->receive(*there, greeting.SerializeAsString());
  close_unused_lanes();
  broadcast_participants();
  return true;
}

// The group's lock must not be held while the host creates a session, because the host locks itself
// and then its sessions.
void LiveSession::change_camera(std::uint64_t connection, bool own, const Error* why) {
  FreeCameraStart start;
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    if (!receiver || ended_) return;
    if (own) {
      start = {receiver->participant, state_.wanted.scene,
               receiver->viewport.width ? receiver->viewport : state_.wanted.viewport,
               receiver->link, weak_from_this()};
    }
  }
  auto made = own ? parts_.open_free_camera(*this, start) : std::shared_ptr<LiveSession>();
  std::shared_ptr<LiveSession> unused;
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    const auto link = links_.find(connection);
    unused = take_free_camera(connection);
    // Otherwise a picture of the free camera could arrive after the group's configuration.
    if (unused) unused->silence();
    if (!made) {
      v1::ServerMessage message;
      *message.mutable_problem() = problem_of(made.error(), 0, false);
      send(connection, message);
    } else if (!receiver || link == links_.end() || ended_ ||
               (own && state_.audience.presents(*receiver))) {
      if (own) unused = *made;  // the viewer left or became the presenter meanwhile
    } else if (own && (*made)->has_ended()) {
      send_problem(connection,
                   {ErrorCode::kTooMany,
                    "No slot is free for a camera of your own. Try again later.", "own_camera"});
    } else if (own) {
      if (!enter_free_camera(connection, *receiver, link->second, *made)) unused = *made;
    } else {
      // Sent first, so that the page does not request the camera again after the configuration.
      if (why) send_problem(connection, *why);
      use_free_camera(state_, *receiver, false, parts_.clock.now());
      if (open_lane(receiver->codec)) send_config(connection);
      broadcast_participants();
    }
  }
  if (unused) unused->dismiss();
  parts_.runner.wake();
}

bool LiveSession::take_camera_back(const std::string& session) {
  std::uint64_t connection = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(free_cameras_.begin(), free_cameras_.end(),
                     [&](const auto& one) { return one.second.session->facts().id == session; });
    if (found == free_cameras_.end()) return false;
    connection = found->first;
  }
  const Error why{ErrorCode::kTooMany,
                  "Your own camera's slot was given to a signed-in user. You now see the "
                  "presenter's view again.",
                  "own_camera_taken"};
  change_camera(connection, false, &why);
  return true;
}

bool LiveSession::has_ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

std::shared_ptr<LiveSession> LiveSession::take_free_camera(std::uint64_t connection) {
  const auto found = free_cameras_.find(connection);
  if (found == free_cameras_.end()) return nullptr;
  std::shared_ptr<LiveSession> session = std::move(found->second.session);
  free_cameras_.erase(found);
  return session;
}

void LiveSession::update_free_cameras() {
  if (led_ == state_.wanted.scene || !state_.wanted.scene) return;
  led_ = state_.wanted.scene;
  for (const auto& [connection, own] : free_cameras_) own.session->follow(*led_);
}

}  // namespace diaphane::render
