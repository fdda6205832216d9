#include "renderd/session/state.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

using google::protobuf::util::MessageDifferencer;

Outcome refuse(ErrorCode code, std::string message, bool fatal) {
  Outcome outcome;
  outcome.problem = problem_of(Error{code, std::move(message), {}}, 0, fatal);
  return outcome;
}

void note_input(SessionState& state, std::uint64_t input_seq, TimePoint now) {
  state.wanted.input_seq = input_seq;
  state.wanted.last_input = now;
  state.unsaved = true;
  if (!state.measured_since) {
    state.measured_input = input_seq;
    state.measured_since = now;
  }
}

Outcome receive_hello(SessionState& state, const v1::Hello& hello, TimePoint now) {
  if (hello.protocol() != 1) {
    return refuse(ErrorCode::kUnsupported,
                  "This page is of another version than the server. Reload it.", true);
  }
  const auto& codecs = hello.codecs();
  if (std::find(codecs.begin(), codecs.end(), v1::JPEG) == codecs.end()) {
    return refuse(ErrorCode::kUnsupported, "This browser decodes none of the picture formats.",
                  true);
  }
  Outcome outcome;
  state.codec = v1::JPEG;
  if (hello.has_viewport()) {
    const auto viewport = check_viewport(hello.viewport());
    if (!viewport) {
      outcome.problem = problem_of(viewport.error(), 0, false);
    } else if (*viewport != state.wanted.viewport) {
      state.wanted.viewport = *viewport;
      ++state.wanted.version;
      state.unsaved = true;
    }
  }
  state.greeted = true;
  state.wanted.last_input = now;  // a first picture is wanted as quickly as after a drag
  state.wanted.picture_again = true;
  outcome.configure = true;
  outcome.wake = true;
  outcome.room = true;
  return outcome;
}

Outcome receive_scene(SessionState& state, const v1::SceneUpdate& update, TimePoint now) {
  Outcome outcome;
  // Order is kept by the stream: a number that does not rise was sent twice.
  if (state.newest_input != 0 && update.input_seq() <= state.newest_input) return outcome;
  state.newest_input = update.input_seq();

  const auto refuse_update = [&](const Error& why) {
    outcome.problem = problem_of(why, update.input_seq(), false);
    return outcome;
  };
  Canvas viewport = state.wanted.viewport;
  if (update.has_viewport()) {
    const auto checked = check_viewport(update.viewport());
    if (!checked) return refuse_update(checked.error());
    viewport = *checked;
  }
  bool changed = viewport != state.wanted.viewport;
  if (update.has_scene()) {
    if (const auto sound = check_scene(update.scene()); !sound) return refuse_update(sound.error());
    if (!state.wanted.scene || !MessageDifferencer::Equals(*state.wanted.scene, update.scene())) {
      state.wanted.scene = std::make_shared<const v1::Scene>(update.scene());
      changed = true;
    }
  }
  state.wanted.viewport = viewport;
  changed = changed || state.wanted.raw != update.raw();
  state.wanted.raw = update.raw();
  if (changed) {
    ++state.wanted.version;
  } else {
    state.wanted.picture_again = true;  // the viewer waits for a frame with this number
  }
  note_input(state, update.input_seq(), now);
  outcome.wake = true;
  return outcome;
}

// A frame of the epoch that is rendered now is always of use. One of the epoch before is of use
// only as the first picture of its epoch: when input comes faster than pictures, all of them are a
// little old, and dropping every one would show nothing until the hand rests. Never after a newer
// one.
bool useful(const SessionState& state, const FrameInfo& frame) {
  if (frame.epoch < state.sent_epoch) return false;
  return frame.epoch >= state.epoch || frame.first_of_epoch;
}

}  // namespace

v1::Problem problem_of(const Error& error, std::uint64_t input_seq, bool fatal) {
  v1::Problem problem;
  problem.set_code(std::string(to_string(error.code)));
  problem.set_message(error.message);
  problem.set_field(error.field);
  problem.set_input_seq(input_seq);
  problem.set_fatal(fatal);
  return problem;
}

Result<Canvas> check_viewport(const v1::Viewport& viewport) {
  const auto side = [](std::uint32_t length, const char* field) -> Result<std::uint32_t> {
    if (length < kSmallestSide) {
      return fail(ErrorCode::kInvalid, "The picture must be at least 16 pixels wide and high.",
                  field);
    }
    if (length > kLargestSide) {
      return fail(ErrorCode::kTooLarge, "The picture may be at most 4096 pixels wide and high.",
                  field);
    }
    return length;
  };
  const auto width = side(viewport.width(), "viewport.width");
  if (!width) return tl::unexpected(width.error());
  const auto height = side(viewport.height(), "viewport.height");
  if (!height) return tl::unexpected(height.error());
  return Canvas{*width, *height};
}

void attach(SessionState& state, TimePoint now) {
  state.attached = true;
  state.greeted = false;
  state.newest_input = 0;
  state.sent_epoch = 0;
  state.converged_told = false;
  state.measured_since.reset();
  state.flight.restart();
  state.heard_at = now;
  state.wanted.visible = true;
}

void detach(SessionState& state, TimePoint now) {
  state.attached = false;
  state.greeted = false;
  state.detached_since = now;
}

Outcome receive(SessionState& state, const v1::ClientMessage& message, TimePoint now) {
  if (!state.greeted && message.body_case() != v1::ClientMessage::kHello) {
    return refuse(ErrorCode::kInvalid, "The connection must begin with a greeting.", true);
  }
  switch (message.body_case()) {
    case v1::ClientMessage::kHello:
      return receive_hello(state, message.hello(), now);
    case v1::ClientMessage::kScene:
      return receive_scene(state, message.scene(), now);
    case v1::ClientMessage::kAck: {
      Outcome outcome;
      outcome.room = state.flight.acknowledge(message.ack().seq());
      outcome.wake = outcome.room;
      if (outcome.room) state.heard_at = now;
      return outcome;
    }
    case v1::ClientMessage::kNeedKey: {
      Outcome outcome;
      state.wanted.picture_again = true;
      outcome.wake = true;
      return outcome;
    }
    case v1::ClientMessage::kVisibility: {
      Outcome outcome;
      const bool visible = message.visibility().visible();
      if (visible && !state.wanted.visible) state.wanted.picture_again = true;
      state.wanted.visible = visible;
      outcome.wake = true;
      return outcome;
    }
    case v1::ClientMessage::BODY_NOT_SET:
      break;
  }
  // Empty, or a kind of message that a newer page knows: no harm.
  return {};
}

void began(SessionState& state, std::uint64_t epoch, const Wanted& wanted) {
  state.epoch = epoch;
  state.shown = wanted;
}

Outcome refused(SessionState& state, const Wanted& wanted, const Error& why) {
  Outcome outcome;
  outcome.problem = problem_of(why, wanted.input_seq, false);
  // Something newer may have come meanwhile: that is tried on its own.
  if (state.wanted.version == wanted.version && state.shown.scene) {
    state.wanted.scene = state.shown.scene;
    state.wanted.viewport = state.shown.viewport;
  }
  state.measured_since.reset();
  return outcome;
}

Admission admit(SessionState& state, const FrameInfo& frame) {
  if (!state.attached || !useful(state, frame)) return Admission::kDrop;
  if (!state.greeted) return Admission::kWait;
  return state.flight.reserve() ? Admission::kGo : Admission::kWait;
}

bool still_useful(const SessionState& state, const FrameInfo& frame) {
  return state.attached && state.greeted && useful(state, frame);
}

Departure depart(SessionState& state, const FrameInfo& frame, TimePoint now) {
  Departure departure;
  if (state.flight.unacknowledged() == 0) state.heard_at = now;
  departure.seq = state.flight.depart();
  state.sent_epoch = frame.epoch;
  if (frame.converged != state.converged_told) {
    departure.state.emplace();
    departure.state->set_epoch(frame.epoch);
    departure.state->set_converged(frame.converged);
    state.converged_told = frame.converged;
  }
  if (state.measured_since && frame.input_seq >= state.measured_input) {
    departure.input_to_frame = std::chrono::duration<double>(now - *state.measured_since).count();
    state.measured_since.reset();
  }
  return departure;
}

bool greeting_overdue(const SessionState& state, TimePoint now) {
  return state.attached && !state.greeted && now - state.heard_at >= kGreetingWithin;
}

bool watched(const SessionState& state, TimePoint now) {
  if (!state.attached || !state.greeted || !state.wanted.visible) return false;
  return state.flight.unacknowledged() == 0 || now - state.heard_at < kStalledAfter;
}

}  // namespace diaphane::render
