#include "renderd/session/free_cameras.h"

#include <algorithm>
#include <utility>

namespace diaphane::render {

Effects FreeCameras::handle(const CameraRequested& event, const SessionState& state) {
  if (!event.on) {
    const auto found = cameras_.find(event.connection);
    if (found == cameras_.end()) return {};  // it is being withdrawn
    return {effect::SilenceCamera{cameras_.extract(found).mapped().session, event.connection,
                                  std::nullopt}};
  }
  const Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  return {
      effect::OpenCamera{event.connection, receiver->participant, receiver->name, receiver->link,
                         receiver->viewer, receiver->may_have_slices, state.requested.scene,
                         receiver->viewport.width ? receiver->viewport : state.requested.viewport}};
}

Effects FreeCameras::handle(const CameraOpened& event, SessionState& state, TimePoint now) {
  Effects effects;
  const auto refuse = [&](const Error& why) {
    effects.emplace_back(problem_to(event.connection, why));
    if (!event.session.empty()) effects.emplace_back(effect::DismissCamera{event.session});
    return std::move(effects);
  };
  if (!event.there) return refuse(event.there.error());
  Receiver* const receiver = state.audience.find(event.connection);
  if (event.gone || !receiver || state.audience.presents(*receiver)) {
    // The viewer left or became the presenter meanwhile.
    return {effect::DismissCamera{event.session}};
  }
  if (event.withdrawn) {
    return refuse({ErrorCode::kTooMany,
                   "No slot is free for a camera of your own. Try again later.", "own_camera"});
  }
  cameras_[event.connection] = {event.session, *event.there};
  use_free_camera(state, *receiver, true, now);
  effect::EnterCamera enter{event.session, *event.there, {}};
  *enter.hello.mutable_hello() = *receiver->hello;
  return {std::move(enter)};
}

Effects FreeCameras::handle(const CameraSilenced& event, SessionState& state, TimePoint now) {
  Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  Effects effects;
  // Sent first, so that the page does not request the camera again after the configuration.
  if (event.why) effects.emplace_back(problem_to(event.connection, *event.why));
  use_free_camera(state, *receiver, false, now);
  effects.emplace_back(effect::Configure{event.connection});
  effects.emplace_back(effect::BroadcastParticipants{});
  effects.emplace_back(effect::WakeRunner{});
  return effects;
}

Effects FreeCameras::handle(const CameraWithdrawn& event) {
  const auto found = std::find_if(cameras_.begin(), cameras_.end(), [&](const auto& one) {
    return one.second.session == event.session;
  });
  if (found == cameras_.end()) return {};
  const std::uint64_t connection = found->first;
  cameras_.erase(found);
  return {effect::SilenceCamera{event.session, connection, event.why}};
}

Effects FreeCameras::handle(const ViewerLeft& event) {
  const auto found = cameras_.find(event.connection);
  if (found == cameras_.end()) return {};
  return {effect::DismissCamera{cameras_.extract(found).mapped().session}};
}

Effects FreeCameras::handle(SessionEnded) {
  Effects effects;
  for (const auto& [connection, camera] : std::exchange(cameras_, {})) {
    effects.emplace_back(effect::DismissCamera{camera.session});
  }
  return effects;
}

Effects FreeCameras::handle(SceneChanged, const SessionState& state) {
  if (led_ == state.requested.scene || !state.requested.scene) return {};
  led_ = state.requested.scene;
  ++number_;
  Effects effects;
  for (const auto& [connection, camera] : cameras_) {
    effects.emplace_back(effect::FollowPresenter{camera.session, led_, number_});
  }
  return effects;
}

const FreeCameras::Camera* FreeCameras::of(std::uint64_t connection) const {
  const auto found = cameras_.find(connection);
  return found == cameras_.end() ? nullptr : &found->second;
}

bool concerns_picture(const v1::ClientMessage& message) {
  return message.has_scene() || message.has_ack() || message.has_need_key() ||
         message.has_visibility() || message.has_depth_query() || message.has_kernel() ||
         message.has_error_curve();
}

}  // namespace diaphane::render
