#include "renderd/session/pictures.h"

#include <algorithm>

namespace diaphane::render {
namespace {

// Returns whether a frame is still worth sending. A frame of the current epoch always is, and one
// of the previous epoch only as the first picture of its epoch. When inputs arrive faster than
// pictures, all pictures are slightly old, and dropping them all would show nothing until the hand
// rests. No frame is useful after a newer one.
bool useful(const SessionState& state, const Receiver& receiver, const FrameInfo& frame) {
  if (frame.epoch < receiver.sent_epoch) return false;
  return frame.epoch >= state.epoch || frame.first_of_epoch;
}

// Returns whether the viewer has this picture, which is being encoded again for another viewer.
bool has(const Receiver& receiver, const FrameInfo& frame) {
  if (!receiver.shown || receiver.behind) return false;
  const FrameInfo& shown = *receiver.shown;
  return shown.epoch == frame.epoch && shown.samples == frame.samples &&
         shown.input_seq == frame.input_seq && shown.moving == frame.moving &&
         shown.converged == frame.converged && shown.denoised == frame.denoised;
}

// Returns whether the viewer needs this frame. Later frames of an inter-coded stream depend on it.
bool wants(const SessionState& state, const Receiver& receiver, const FrameInfo& frame) {
  if (!useful(state, receiver, frame)) return false;
  return is_inter_coded(receiver.codec) || !has(receiver, frame);
}

// Returns the presenter if they set the pace of all viewers with the same codec: while they
// acknowledge pictures.
const Receiver* pacer(const SessionState& state, v1::Codec codec, TimePoint now) {
  const Receiver* presenter = state.audience.of(state.audience.presenter);
  if (!presenter || presenter->codec != codec || !is_watching(*presenter, now)) return nullptr;
  const bool keeps_up =
      presenter->flight.unacknowledged() == 0 || now - presenter->last_progress_at < kPaceFor;
  return keeps_up ? presenter : nullptr;
}

// Limits a frame for several viewers to what the connection of the viewer who sets the pace
// permits, or else the fastest connection. Slower viewers run out of room and skip frames.
Admitted allowance(SessionState& state, const Coding& coding, const Receiver* pace, bool key,
                   TimePoint now) {
  Admitted admitted{Admission::kGo, key};
  for (const std::uint64_t connection : coding.takers) {
    Receiver& taker = *state.audience.find(connection);
    update_quality(state, taker, now);
    if (pace && pace != &taker) continue;
    const QualityPlan& plan = taker.quality.plan();
    admitted.moving_bytes = std::max(admitted.moving_bytes, plan.moving_bytes);
    admitted.settled_bytes = std::max(admitted.settled_bytes, plan.settled_bytes);
  }
  return admitted;
}

void miss(Receiver& receiver) {
  receiver.behind = true;
  if (is_inter_coded(receiver.codec)) receiver.needs_key = true;
}

}  // namespace

void update_quality(SessionState& state, Receiver& receiver, TimePoint now) {
  const QualityPlan& plan =
      receiver.quality.update(receiver.path, state.requested.viewport, receiver.codec, now);
  receiver.flight.set_limit(plan.window_frames);
  if (state.audience.presents(receiver)) state.requested.moving_scale = plan.moving_scale;
}

Admitted admit(SessionState& state, v1::Codec codec, const FrameInfo& frame, TimePoint now) {
  Audience& audience = state.audience;
  if (const auto coding = audience.codings.find(codec);
      coding != audience.codings.end() && !coding->second.takers.empty()) {
    return {Admission::kWait};  // only one picture per codec is encoded at a time
  }
  const bool inter = is_inter_coded(codec);
  std::vector<Receiver*> recipients;
  std::vector<Receiver*> others;
  for (Receiver& receiver : audience.receivers) {
    if (!receiver.greeted || receiver.codec != codec || receiver.free_camera) continue;
    const bool watching = is_watching(receiver, now);
    if (!watching) receiver.behind = true;  // until it is visible or responds again
    (watching && wants(state, receiver, frame) ? recipients : others).push_back(&receiver);
  }
  if (recipients.empty()) return {};

  const auto with_room = [](const Receiver* one) { return has_room(*one); };
  const Receiver* pace = pacer(state, codec, now);
  const bool paced =
      pace && std::find(recipients.begin(), recipients.end(), pace) != recipients.end();
  const bool room =
      paced ? with_room(pace) : std::any_of(recipients.begin(), recipients.end(), with_room);
  if (!room) return {Admission::kWait};

  Coding& coding = audience.codings[codec];
  const bool key_may = !coding.key_at || now - *coding.key_at >= kKeyEvery;
  const bool key =
      inter && std::any_of(recipients.begin(), recipients.end(), [&](const Receiver* one) {
        return one->needs_key && with_room(one) && (key_may || one == pace);
      });
  const auto takes = [&](const Receiver* one) {
    return with_room(one) && (!inter || key || !one->needs_key);
  };
  // All viewers with room wait for a key frame, which is not due yet.
  if (std::none_of(recipients.begin(), recipients.end(), takes)) return {Admission::kWait};

  if (key) coding.key_at = now;
  if (inter) std::for_each(others.begin(), others.end(), [](Receiver* one) { miss(*one); });
  coding.takers.clear();
  for (Receiver* one : recipients) {
    if (!takes(one)) {
      miss(*one);
      continue;
    }
    one->flight.reserve();
    one->behind = false;
    coding.takers.push_back(one->connection);
  }
  return allowance(state, coding, pace, key, now);
}

OutgoingFrames depart(SessionState& state, v1::Codec codec, const FrameInfo& frame, CodedSize coded,
                      TimePoint now) {
  OutgoingFrames outgoing_frames;
  for (const std::uint64_t connection : std::exchange(state.audience.codings[codec].takers, {})) {
    Receiver* const receiver = state.audience.find(connection);
    if (!receiver) continue;
    const bool decodes = coded.key || !receiver->needs_key;
    if (receiver->free_camera || !decodes || !useful(state, *receiver, frame)) {
      receiver->flight.release();
      // Later frames of an inter-coded stream depend on this dropped one.
      if (is_inter_coded(codec)) miss(*receiver);
      continue;
    }
    OutgoingFrame outgoing;
    outgoing.connection = connection;
    if (receiver->flight.unacknowledged() == 0) receiver->last_progress_at = now;
    outgoing.seq = receiver->flight.depart();
    receiver->path.sent(outgoing.seq, coded.bytes, now);
    receiver->tiles_sent = 0;  // the frame covers the tiles
    receiver->sent_epoch = frame.epoch;
    receiver->shown = frame;
    receiver->needs_key = false;
    if (!state.audience.presents(*receiver) && receiver->look_version != state.shown.version) {
      receiver->look_version = state.shown.version;
      outgoing.look = true;
    }
    if (frame.converged != receiver->converged_sent || receiver->lossless_sent) {
      receiver->lossless_sent = false;
      outgoing.state.emplace();
      outgoing.state->set_epoch(frame.epoch);
      outgoing.state->set_converged(frame.converged);
      receiver->converged_sent = frame.converged;
    }
    outgoing_frames.frames.push_back(std::move(outgoing));
  }
  if (!outgoing_frames.frames.empty() && state.measured_since &&
      frame.input_seq >= state.measured_input) {
    outgoing_frames.input_to_frame =
        std::chrono::duration<double>(now - *state.measured_since).count();
    state.measured_since.reset();
  }
  return outgoing_frames;
}

void release(SessionState& state, v1::Codec codec) {
  for (const std::uint64_t connection : std::exchange(state.audience.codings[codec].takers, {})) {
    Receiver* const receiver = state.audience.find(connection);
    if (!receiver) continue;
    receiver->flight.release();
    miss(*receiver);
  }
}

std::vector<TileDue> tiles_due(const SessionState& state, const FrameInfo& last,
                               std::uint32_t tiles, TimePoint now) {
  std::vector<TileDue> due;
  if (state.epoch != last.epoch) return due;
  for (const Receiver& one : state.audience.receivers) {
    if (one.stills == v1::STILL_FORMAT_UNSPECIFIED || !one.shown || one.behind) continue;
    const bool has_frame = one.shown->converged && one.shown->epoch == last.epoch &&
                           one.shown->samples == last.samples;
    if (!has_frame || one.tiles_sent >= tiles || !is_watching(one, now) || !has_room(one)) continue;
    due.push_back({one.connection, one.tiles_sent, one.stills});
  }
  return due;
}

OutgoingFrame depart_tile(SessionState& state, const TileDue& due, std::uint32_t tiles,
                          std::size_t bytes, TimePoint now) {
  OutgoingFrame outgoing;
  outgoing.connection = due.connection;
  Receiver& receiver = *state.audience.find(due.connection);
  if (receiver.flight.unacknowledged() == 0) receiver.last_progress_at = now;
  receiver.flight.reserve();
  outgoing.seq = receiver.flight.depart();
  receiver.path.sent(outgoing.seq, bytes, now);
  receiver.tiles_sent = due.tile + 1;
  if (receiver.tiles_sent == tiles) {
    outgoing.state.emplace();
    outgoing.state->set_epoch(receiver.shown->epoch);
    outgoing.state->set_converged(true);
    outgoing.state->set_lossless(true);
    receiver.lossless_sent = true;
  }
  return outgoing;
}

bool has_room(const SessionState& state, v1::Codec codec, TimePoint now) {
  if (const Receiver* pace = pacer(state, codec, now)) return has_room(*pace);
  const auto& receivers = state.audience.receivers;
  return std::any_of(receivers.begin(), receivers.end(), [&](const Receiver& one) {
    return one.codec == codec && is_watching(one, now) && has_room(one);
  });
}

}  // namespace diaphane::render
