#include "renderd/session/slices.h"

#include <google/protobuf/util/message_differencer.h>

#include <utility>

namespace diaphane::render {
namespace {

/// A phase that stays this long is not being played.
constexpr std::chrono::milliseconds kPhaseSettled{500};

bool same_clip(const std::optional<v1::Clip>& a, const std::optional<v1::Clip>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return google::protobuf::util::MessageDifferencer::Equals(*a, *b);
}

/// Returns the order for a slice, or nullopt if this viewer may not receive it.
std::optional<SliceOrder> order_of(const SessionState& state, const Receiver& receiver,
                                   const volume::SliceStack& stack, const SliceDue& due,
                                   TimePoint now) {
  switch (slice_access(state.audience.rights(receiver))) {
    case SliceAccess::kNone:
      break;
    case SliceAccess::kShown:
      if (!state.audience.shows(stack, due, now)) break;
      [[fallthrough]];
    case SliceAccess::kClipped:
      // The newest clip, even if no picture shows it yet.
      if (state.requested.scene) return SliceOrder{due, state.requested.scene->clip()};
      break;
    case SliceAccess::kWhole:
      return SliceOrder{due, std::nullopt};
  }
  return std::nullopt;
}

v1::ServerMessage message_of(const volume::SliceStack& stack, std::uint64_t seq, SliceCoded coded) {
  const SliceDue& due = coded.order.due;
  v1::ServerMessage message;
  v1::ExactSlice& slice = *message.mutable_slice();
  slice.set_seq(seq);
  if (due.curved) {
    slice.set_columns(due.curved->columns);
    slice.set_rows(due.curved->rows);
    slice.set_curved(due.curved->id);
  } else {
    slice.set_plane(to_proto(stack.plane));
    slice.set_index(due.index);
    slice.set_columns(due.oblique ? due.oblique->columns : stack.columns);
    slice.set_rows(due.oblique ? due.oblique->rows : stack.rows);
  }
  slice.set_data(*std::move(coded.coded));
  slice.set_second(std::move(coded.second));
  slice.set_labels(std::move(coded.labels));
  slice.set_oblique(due.oblique ? due.oblique->id : 0);
  return message;
}

effect::Send stale_message(std::uint64_t connection) {
  effect::Send send{connection, {}};
  send.message.mutable_slices_stale();
  return send;
}

}  // namespace

effect::Send problem_to(std::uint64_t connection, const Error& why) {
  effect::Send send{connection, {}};
  *send.message.mutable_problem() = problem_of(why, 0, false);
  return send;
}

Effects Slices::handle(const SlicesKnown& event) {
  stacks_ = event.stacks;
  header_ = event.header;
  return {};
}

Effects Slices::handle(const SlicesRequested& event, SessionState& state, TimePoint now) {
  Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver || !stacks_) return {};  // pages request slices only after they learn of them
  if (const auto noted = receiver->slices.replace(event.request, *stacks_, header_); !noted) {
    return {problem_to(event.connection, noted.error())};
  }
  const std::uint32_t phase = phase_of(state);
  const bool loaded = voxels_ && voxels_->volume().phase == phase;
  if (!loaded && receiver->slices.waiting()) {
    if (std::exchange(loading_, true)) return {};
    return {effect::LoadVoxels{phase}};
  }
  Effects effects;
  take_next(effects, state, event.connection, now);
  return effects;
}

Effects Slices::handle(const VoxelsLoaded& event, SessionState& state, TimePoint now) {
  Effects effects;
  loading_ = false;
  auto host = event.loaded ? std::dynamic_pointer_cast<const HostVolume>(*event.loaded) : nullptr;
  // If the volume was replaced in the store, the session is about to be notified.
  const bool same = host && host->header().content_hash == event.shown_hash;
  if (same) {
    phase_ = host->volume().phase;
    voxels_ = std::move(host);
  }
  for (Receiver& receiver : state.audience.receivers) {
    if (!receiver.slices.waiting()) continue;
    if (same) {
      take_next(effects, state, receiver.connection, now);
      continue;
    }
    receiver.slices = {};
    effects.emplace_back(effect::Warn{"slices_failed"});
    effects.emplace_back(
        problem_to(receiver.connection,
                   {event.loaded ? ErrorCode::kUnavailable : event.loaded.error().code,
                    "The slices can't be shown right now. The 3D view continues.", "slices"}));
  }
  return effects;
}

void Slices::take_next(Effects& effects, SessionState& state, std::uint64_t connection,
                       TimePoint now) const {
  Receiver* const receiver = state.audience.find(connection);
  if (!receiver || !voxels_ || !receiver->slices.ready()) return;
  const bool guest = receiver->viewer == ViewerKind::kGuest;
  // Over the limit, SlicesTicked tries again.
  if (!state.audience.slice_allowances.take(receiver->participant, guest, now)) return;
  while (const auto due = receiver->slices.take()) {
    const volume::SliceStack& stack = (*stacks_)[due->plane];
    if (auto order = order_of(state, *receiver, stack, *due, now)) {
      if (const std::uint64_t samples = due->samples(header_); samples > 0) {
        state.audience.slice_allowances.charge(receiver->participant, guest, samples);
      }
      effects.emplace_back(effect::CodeSlice{connection, *std::move(order), stack, voxels_, guest,
                                             may_know_labels(receiver->viewer)});
      return;
    }
    receiver->slices.give_up();
  }
}

Effects Slices::handle(SliceCoded event, SessionState& state, TimePoint now) {
  Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  if (!event.coded) {
    receiver->slices.give_up();
    return {problem_to(event.connection, event.coded.error())};
  }
  Effects effects;
  const SliceOrder& order = event.order;
  // Meanwhile slices may have been switched off, or the clip may have changed.
  const auto still = order_of(state, *receiver, (*stacks_)[order.due.plane], order.due, now);
  if (!still) {
    receiver->slices.give_up();
  } else if (!same_clip(still->clip, order.clip)) {
    receiver->slices.put_back();
  } else {
    receiver->has_slices = true;
    receiver->has_clipped_slices = order.clip.has_value();
    const volume::SliceStack& stack = (*stacks_)[order.due.plane];
    effects.emplace_back(effect::Send{
        receiver->connection, message_of(stack, receiver->slices.depart(), std::move(event))});
  }
  take_next(effects, state, receiver->connection, now);
  return effects;
}

Effects Slices::handle(SlicesTicked, SessionState& state, TimePoint now) {
  Effects effects = handle(SceneChanged{}, state, now);
  for (const Receiver& receiver : state.audience.receivers) {
    if (receiver.slices.waiting()) take_next(effects, state, receiver.connection, now);
  }
  return effects;
}

std::uint32_t Slices::phase_of(const SessionState& state) const {
  const auto& scene = state.requested.scene;
  return scene ? std::min(scene->volume_phase(), header_.phase_count() - 1) : 0;
}

/// Returns whether the phase has changed since the viewers got slices, and is not being played.
/// Each phase would have to be read from disk.
bool Slices::other_phase(const SessionState& state, TimePoint now) {
  const std::uint32_t phase = phase_of(state);
  const bool settled = now - phase_changed_ >= kPhaseSettled;
  if (std::exchange(newest_phase_, phase) != phase) phase_changed_ = now;
  if (!settled) return false;
  return std::exchange(phase_, phase) != phase;
}

Effects Slices::handle(SceneChanged, SessionState& state, TimePoint now) {
  const bool phase_differs = other_phase(state, now);
  const auto before = std::exchange(clipped_by_, state.requested.scene);
  const bool clip_differs =
      before != clipped_by_ &&
      (!before || !clipped_by_ || !same_clip(before->clip(), clipped_by_->clip()));
  Effects effects;
  for (Receiver& receiver : state.audience.receivers) {
    const bool stale =
        (phase_differs && receiver.has_slices) || (clip_differs && receiver.has_clipped_slices);
    if (!stale) continue;
    receiver.has_slices = receiver.has_clipped_slices = false;
    effects.emplace_back(stale_message(receiver.connection));
  }
  return effects;
}

Effects Slices::handle(LabelsReplaced, SessionState& state) {
  voxels_.reset();  // the next request loads them with the new labels
  Effects effects;
  for (Receiver& receiver : state.audience.receivers) {
    if (!receiver.has_slices || !may_know_labels(receiver.viewer)) continue;
    receiver.has_slices = receiver.has_clipped_slices = false;
    effects.emplace_back(stale_message(receiver.connection));
  }
  return effects;
}

Effects Slices::handle(AllViewersLeft) {
  voxels_.reset();
  return {};
}

}  // namespace diaphane::render
