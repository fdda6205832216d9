// A follower with a free camera gets a separate session beside the group's (docs/adr/0013).
#include "renderd/serve/session_turn.h"
#include "renderd/session/good_views.h"

namespace diaphane::render {

void LiveSession::silence() {
  const Turn turn(*this);
  links_.clear();
}

void LiveSession::dismiss() {
  silence();
  end({ErrorCode::kConflict, "The session is no longer needed.", {}});
  on_ended_({ErrorCode::kUnavailable, "The session has no viewers.", {}});
}

void LiveSession::follow(const v1::Scene& presenters, std::uint64_t number) {
  const Turn turn(*this);
  if (number <= followed_) return;
  followed_ = number;
  render::follow(state_, presenters, turn.now);
  publish_version();
  apply(Effects{effect::WakeRunner{}});
}

std::shared_ptr<LiveSession> LiveSession::camera(const std::string& session) const {
  const std::lock_guard lock(mutex_);
  const auto found = camera_sessions_.find(session);
  return found == camera_sessions_.end() ? nullptr : found->second;
}

void LiveSession::carry_out(const effect::OpenCamera& effect) {
  const auto made = parts_.open_free_camera(
      *this, {effect.participant, effect.scene, effect.viewport, effect.link, weak_from_this()});
  CameraOpened opened{effect.connection, {}, std::uint64_t{0}};
  if (!made) {
    opened.there = tl::unexpected(made.error());
  } else {
    opened.session = (*made)->facts().id;
    std::shared_ptr<ClientLink> link;
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = links_.find(effect.connection); found != links_.end() && !ended_) {
        link = found->second;
      }
    }
    const SessionStatus status = (*made)->status();
    if (link) {
      opened.there = (*made)->attach(
          std::move(link),
          {effect.participant, effect.name, {}, effect.viewer, effect.may_have_slices},
          {status.placement, status.visitor});
    }
  }
  const Turn turn(*this);
  if (made) {
    camera_sessions_.emplace(opened.session, *made);
    // SessionHost::end_evicted() ends the camera's session before it calls take_camera_back(). So
    // either this check or that call notices that the slot has gone to another session.
    opened.withdrawn = (*made)->ended_;
    opened.gone = ended_ || !links_.contains(effect.connection);
  }
  apply(cameras_.handle(opened, state_, turn.now));
}

void LiveSession::carry_out(const effect::EnterCamera& effect) {
  if (const auto own = camera(effect.session)) own->dispatch(effect.connection, effect.hello);
  const Turn turn(*this);
  close_unused_lanes();
  broadcast_participants();
  apply(Effects{effect::WakeRunner{}});
}

void LiveSession::carry_out(const effect::ForwardToCamera& effect) {
  if (const auto own = camera(effect.session)) own->dispatch(effect.connection, effect.message);
}

std::shared_ptr<LiveSession> LiveSession::seen_by(std::uint64_t connection) {
  std::string own;
  {
    const std::lock_guard lock(mutex_);
    if (const auto* known = cameras_.of(connection)) own = known->session;
  }
  return own.empty() ? shared_from_this() : camera(own);
}

void LiveSession::carry_out(const effect::FindPointer& effect) {
  const std::shared_ptr<LiveSession> seen = seen_by(effect.connection);
  const auto visible = seen ? seen->visible_at(effect.x, effect.y) : std::nullopt;
  PointerFound found{effect.connection, effect.number, std::nullopt};
  if (visible) found.place = visible->place;
  const Turn turn(*this);
  apply(collaboration_.handle(found, state_, turn.now));
}

void LiveSession::carry_out(const effect::FindMarkSight& effect) {
  const std::shared_ptr<LiveSession> seen = seen_by(effect.connection);
  std::vector<Collaboration::PlacedMark> marks;
  {
    const std::lock_guard lock(mutex_);
    marks = collaboration_.placed_marks();
  }
  std::vector<Double3> places;
  for (const auto& mark : marks) places.push_back(mark.place);
  const std::vector<bool> hidden =
      seen ? seen->hidden_marks(places) : std::vector<bool>(places.size());
  v1::ServerMessage message;
  v1::MarkSight& sight = *message.mutable_mark_sight();
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!hidden[i]) continue;
    const int last = sight.hidden_size() - 1;
    v1::MarkSight::Hidden& of = last >= 0 && sight.hidden(last).number() == marks[i].number
                                    ? *sight.mutable_hidden(last)
                                    : *sight.add_hidden();
    of.set_number(marks[i].number);
    of.add_ids(marks[i].id);
  }
  const std::lock_guard lock(mutex_);
  send(effect.connection, message);
}

void LiveSession::carry_out(const effect::FindGoodViews& effect) {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<const v1::Scene> scene = state_.requested.scene;
  const auto coarse = volume_ ? parts_.stats.of(*volume_).coarse : nullptr;
  const CoarseSecond second = coarse_second();
  lock.unlock();
  if (!scene || !coarse) {
    lock.lock();
    carry_out(problem_to(effect.connection,
                         {ErrorCode::kUnavailable,
                          "The scan is still loading. Try again in a moment.", "good_views"}));
    return;
  }
  v1::ServerMessage message;
  *message.mutable_good_views() = to_proto(good_views(*coarse, *scene, second));
  lock.lock();
  send(effect.connection, message);
}

void LiveSession::carry_out(const effect::FollowPresenter& effect) {
  if (const auto own = camera(effect.session)) own->follow(*effect.scene, effect.number);
}

void LiveSession::carry_out(const effect::SilenceCamera& effect) {
  // Otherwise a picture of the free camera could arrive after the group's configuration.
  if (const auto own = camera(effect.session)) own->silence();
  {
    const Turn turn(*this);
    if (!ended_) {
      apply(cameras_.handle(CameraSilenced{effect.connection, effect.why}, state_, turn.now));
    }
  }
  carry_out(effect::DismissCamera{effect.session});
}

void LiveSession::carry_out(const effect::DismissCamera& effect) {
  const auto own = camera(effect.session);
  if (!own) return;
  own->dismiss();
  const std::lock_guard lock(mutex_);
  camera_sessions_.erase(effect.session);
}

bool LiveSession::take_camera_back(const std::string& session) {
  const Turn turn(*this);
  Effects effects = cameras_.handle(CameraWithdrawn{
      session,
      {ErrorCode::kTooMany,
       "Your own camera's slot was given to a signed-in user. You now see the presenter's view "
       "again.",
       "own_camera_taken"}});
  const bool used = !effects.empty();
  apply(std::move(effects));
  return used;
}

}  // namespace diaphane::render
