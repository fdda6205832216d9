#include "renderd/session/state.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cmath>

#include "common/try.h"
#include "renderd/scene/presets.h"
#include "renderd/session/pictures.h"

namespace diaphane::render {
namespace {

using google::protobuf::util::MessageDifferencer;

Outcome refuse(ErrorCode code, std::string message, bool fatal) {
  Outcome outcome;
  outcome.problem = problem_of(Error{code, std::move(message), {}}, 0, fatal);
  return outcome;
}

v1::Problem not_greeted() {
  return problem_of({ErrorCode::kInvalid, "The connection must start with a hello message.", {}}, 0,
                    true);
}

void note_input(SessionState& state, std::uint64_t input_seq, bool rest, TimePoint now) {
  state.requested.input_seq = input_seq;
  state.requested.last_input = now;
  state.requested.rest = rest;
  state.unsaved = true;
  if (!state.measured_since) {
    state.measured_input = input_seq;
    state.measured_since = now;
  }
}

// Takes the picture's size from the presenter's page. Returns whether it changed.
bool take_viewport(SessionState& state, const Receiver& receiver) {
  const Canvas viewport = receiver.viewport;
  if (viewport.width == 0 || viewport == state.requested.viewport) return false;
  state.requested.viewport = viewport;
  ++state.requested.version;
  state.unsaved = true;
  return true;
}

// Prefers WebP if the page supports it, because it is smaller (docs/figures/still-codecs.json).
v1::StillFormat preferred_still(const v1::Hello& hello) {
  for (const v1::StillFormat format : {v1::WEBP, v1::PNG}) {
    const auto& shown = hello.stills();
    if (std::find(shown.begin(), shown.end(), format) != shown.end()) return format;
  }
  return v1::STILL_FORMAT_UNSPECIFIED;
}

Outcome receive_hello(SessionState& state, Receiver& receiver, const v1::Hello& hello,
                      TimePoint now) {
  if (hello.protocol() != 1) {
    return refuse(ErrorCode::kUnsupported,
                  "This page and the server have different versions. Reload the page.", true);
  }
  const auto supported = [&](int codec) {
    return std::find(state.codecs.begin(), state.codecs.end(), codec) != state.codecs.end();
  };
  const auto& codecs = hello.codecs();
  const auto chosen = std::find_if(codecs.begin(), codecs.end(), supported);
  if (chosen == codecs.end()) {
    return refuse(ErrorCode::kUnsupported,
                  "This browser supports none of the available video formats.", true);
  }
  Outcome outcome;
  receiver.codec = static_cast<v1::Codec>(*chosen);
  receiver.hello = std::make_shared<const v1::Hello>(hello);
  receiver.stills = preferred_still(hello);
  receiver.tiles_sent = 0;
  receiver.needs_key = true;
  receiver.behind = true;
  if (hello.has_viewport()) {
    const auto viewport = check_viewport(hello.viewport());
    if (!viewport) {
      outcome.problem = problem_of(viewport.error(), 0, false);
    } else {
      receiver.viewport = *viewport;
    }
  }
  receiver.greeted = true;
  if (state.audience.presents(receiver)) {
    take_viewport(state, receiver);
    state.requested.last_input = now;  // the first picture is as urgent as one after a drag
  }
  state.requested.picture_again = true;
  outcome.configure = true;
  outcome.audience = true;
  outcome.wake = true;
  outcome.room = true;
  return outcome;
}

Outcome refuse_follower(const v1::SceneUpdate& update) {
  Outcome outcome;
  if (update.has_scene()) {
    const Error why{ErrorCode::kForbidden, "Only the presenter can make changes.", {}};
    outcome.problem = problem_of(why, update.input_seq(), false);
  }
  return outcome;
}

Outcome receive_scene(SessionState& state, Receiver& receiver, const v1::SceneUpdate& update,
                      TimePoint now) {
  Outcome outcome;
  // The stream preserves order, so a number that does not rise is a duplicate.
  if (receiver.newest_input != 0 && update.input_seq() <= receiver.newest_input) return outcome;
  receiver.newest_input = update.input_seq();

  const auto refuse_update = [&](const Error& why) {
    outcome.problem = problem_of(why, update.input_seq(), false);
    return outcome;
  };
  Canvas viewport = state.requested.viewport;
  if (update.has_viewport()) {
    const auto checked = check_viewport(update.viewport());
    if (!checked) return refuse_update(checked.error());
    viewport = *checked;
    receiver.viewport = viewport;  // also stored for followers, in case they become the presenter
  }
  if (!state.audience.presents(receiver)) return refuse_follower(update);

  const auto effort = check_effort(update.effort());
  if (!effort) return refuse_update(effort.error());
  bool changed = viewport != state.requested.viewport;
  if (update.has_scene()) {
    const v1::Scene* const now_shown = state.requested.scene.get();
    std::optional<v1::Scene> allowed;
    if (!state.camera_only) {
      allowed = allowed_scene(state.audience.rights(receiver), now_shown, update.scene());
    } else if (now_shown) {
      allowed = *now_shown;
      *allowed->mutable_camera() = update.scene().camera();
    }
    if (!allowed) {
      return refuse_update({ErrorCode::kUnavailable, "The 3D view is not ready yet.", {}});
    }
    auto scene = std::make_shared<v1::Scene>(*std::move(allowed));
    if (const auto sound = check_scene(*scene); !sound) return refuse_update(sound.error());
    if (!state.requested.scene || !MessageDifferencer::Equals(*state.requested.scene, *scene)) {
      state.requested.scene = std::move(scene);
      changed = true;
    }
  }
  state.requested.viewport = viewport;
  // A changed limit needs a new picture, because nothing more is sent for a finished one.
  changed = changed || state.requested.raw != update.raw() ||
            state.requested.effort.stop_error != effort->stop_error ||
            state.requested.effort.stop_samples != effort->stop_samples;
  state.requested.raw = update.raw();
  state.requested.effort = *effort;
  if (changed) {
    ++state.requested.version;
  } else {
    state.requested.picture_again = true;  // the viewer waits for a frame with this number
  }
  note_input(state, update.input_seq(), update.rest(), now);
  outcome.wake = true;
  return outcome;
}

Outcome receive_ack(SessionState& state, Receiver& receiver, const v1::Ack& ack, TimePoint now) {
  Outcome outcome;
  if (!receiver.flight.acknowledge(ack.seq())) return outcome;
  receiver.last_progress_at = now;
  receiver.path.acknowledged(ack.seq(), now);
  update_quality(state, receiver, now);
  // Without a new picture, the missed one would never arrive.
  if (receiver.behind) state.requested.picture_again = true;
  outcome.room = true;
  outcome.wake = true;
  return outcome;
}

Outcome receive_need_key(SessionState& state, Receiver& receiver) {
  receiver.needs_key = true;
  receiver.behind = true;
  state.requested.picture_again = true;
  Outcome outcome;
  outcome.wake = true;
  return outcome;
}

Outcome receive_visibility(SessionState& state, Receiver& receiver, bool visible) {
  if (visible && !receiver.visible) {
    receiver.behind = true;
    state.requested.picture_again = true;
  }
  receiver.visible = visible;
  Outcome outcome;
  outcome.wake = true;
  return outcome;
}

Outcome receive_depth_query(Receiver& receiver, const v1::DepthQuery& query, TimePoint now) {
  const auto within = [](double part) { return part >= 0 && part <= 1; };
  if (!within(query.x()) || !within(query.y())) {
    return refuse(ErrorCode::kInvalid, "This point is outside the image.", false);
  }
  if (receiver.depth_asked && now - *receiver.depth_asked < kDepthEvery) {
    return refuse(ErrorCode::kTooMany, "Too many depth requests.", false);
  }
  receiver.depth_asked = now;
  Outcome outcome;
  outcome.depth = query;
  return outcome;
}

Outcome receive_kernel_wanted(SessionState& state, Receiver& receiver, TimePoint now) {
  if (receiver.kernel_asked && now - *receiver.kernel_asked < kKernelEvery) {
    return refuse(ErrorCode::kTooMany, "Too many requests for render details.", false);
  }
  receiver.kernel_asked = now;
  receiver.kernel_wanted = true;
  state.requested.kernel_report = true;
  state.requested.picture_again = true;
  Outcome outcome;
  outcome.wake = true;
  return outcome;
}

Outcome receive_curve_query(Receiver& receiver, TimePoint now) {
  if (receiver.curve_asked && now - *receiver.curve_asked < kKernelEvery) {
    return refuse(ErrorCode::kTooMany, "Too many requests for the error curve.", false);
  }
  receiver.curve_asked = now;
  Outcome outcome;
  outcome.error_curve = true;
  return outcome;
}

Outcome receive_good_views_query(Receiver& receiver, TimePoint now) {
  Outcome outcome;
  if (receiver.good_views_asked && now - *receiver.good_views_asked < kKernelEvery) {
    outcome.problem = problem_of(
        {ErrorCode::kTooMany, "Too many requests for good views.", "good_views"}, 0, false);
    return outcome;
  }
  receiver.good_views_asked = now;
  outcome.good_views = true;
  return outcome;
}

Outcome receive_handover(SessionState& state, Receiver& receiver, const v1::Handover& handover) {
  Outcome outcome;
  const std::string before = state.audience.presenter;
  if (const auto given = hand_over(state.audience, receiver, handover.to()); !given) {
    outcome.problem = problem_of(given.error(), 0, false);
    return outcome;
  }
  if (state.audience.presenter == before) return outcome;
  const Receiver& presenter = *state.audience.of(state.audience.presenter);
  take_viewport(state, presenter);
  state.unsaved = true;
  outcome.audience = true;
  outcome.presenter = true;
  outcome.wake = true;
  return outcome;
}

/// Drops requests for slices that guests may no longer receive after slices were turned off or
/// closed.
void forget_guest_slices(Audience& audience) {
  for (Receiver& one : audience.receivers) {
    if (slice_access(audience.rights(one)) == SliceAccess::kNone) one.slices.forget();
  }
}

Outcome receive_guest_slices(SessionState& state, bool on) {
  Outcome outcome;
  if (state.audience.guest_slices == on) return outcome;
  state.audience.guest_slices = on;
  forget_guest_slices(state.audience);
  state.unsaved = true;
  outcome.audience = true;
  return outcome;
}

/// Updates which slices guests may request. Collaboration passes the presenter's view on.
Outcome receive_slice_view(SessionState& state, const v1::SliceView& view, TimePoint now) {
  Outcome outcome;
  const bool before = state.audience.shows_slices();
  state.audience.show(view, now);
  if (state.audience.shows_slices() == before) return outcome;
  forget_guest_slices(state.audience);
  outcome.audience = true;
  return outcome;
}

Outcome receive_guest_pointers(SessionState& state, bool on) {
  Outcome outcome;
  outcome.audience = std::exchange(state.audience.guest_pointers, on) != on;
  return outcome;
}

/// Raises or lowers a hand. Everyone can lower their own hand, and the presenter anyone's.
Outcome receive_hand(SessionState& state, Receiver& receiver, const v1::RaiseHand& hand) {
  const bool own = hand.of().empty() || hand.of() == receiver.participant;
  if (!own && (hand.on() || !state.audience.presents(receiver))) {
    return refuse(ErrorCode::kForbidden, "Only the presenter can lower the hands of others.",
                  false);
  }
  Receiver* const whose = own ? &receiver : state.audience.of(hand.of());
  Outcome outcome;
  if (!whose || (whose->hand != 0) == hand.on()) return outcome;
  whose->hand = hand.on() ? ++state.audience.hands : 0;
  outcome.audience = true;
  return outcome;
}

Outcome receive_free_camera(SessionState& state, Receiver& receiver, bool on) {
  Outcome outcome;
  if (receiver.free_camera == on) return outcome;
  if (on && state.audience.presents(receiver)) {
    return refuse(ErrorCode::kConflict,
                  "The presenter's camera is shared with everyone in the session.", false);
  }
  outcome.free_camera = on;
  return outcome;
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

Result<Effort> check_effort(const v1::Effort& effort) {
  const double error = effort.stop_error(), scale = effort.moving_scale();
  // These conditions refuse NaN as well.
  if (!(error >= 0 && error <= 1)) {
    return fail(ErrorCode::kInvalid, "The target error must be between 0 and 1.",
                "effort.stop_error");
  }
  if (scale != 0 && !(scale >= kSmallestMovingScale && scale <= 1)) {
    return fail(ErrorCode::kInvalid, "The resolution while moving must be between 0.1 and 1.",
                "effort.moving_scale");
  }
  return Effort{error, effort.stop_samples(), scale == 0 ? 1 : scale};
}

Canvas visitor_canvas(Canvas viewport) {
  const double pixels = double(viewport.width) * double(viewport.height);
  if (pixels <= kMostVisitorPixels) return viewport;
  const double scale = std::sqrt(kMostVisitorPixels / pixels);
  const auto side = [scale](std::uint32_t length) {
    return std::max(static_cast<std::uint32_t>(length * scale), kSmallestSide);
  };
  return {side(viewport.width), side(viewport.height)};
}

Result<Canvas> check_viewport(const v1::Viewport& viewport) {
  const auto side = [](std::uint32_t length, const char* field) -> Result<std::uint32_t> {
    if (length < kSmallestSide) {
      return fail(ErrorCode::kInvalid, "The image must be at least 16 pixels wide and high.",
                  field);
    }
    if (length > kLargestSide) {
      return fail(ErrorCode::kTooLarge, "The image must be at most 4096 pixels wide and high.",
                  field);
    }
    return length;
  };
  const auto width = side(viewport.width(), "viewport.width");
  DIAPHANE_TRY(width);
  const auto height = side(viewport.height(), "viewport.height");
  DIAPHANE_TRY(height);
  return Canvas{*width, *height};
}

namespace {

std::uint32_t smallest_free_number(const Audience& audience) {
  const auto taken = [&](std::uint32_t number) {
    return std::ranges::any_of(audience.receivers,
                               [=](const Receiver& one) { return one.number == number; });
  };
  std::uint32_t number = 0;
  while (taken(number)) ++number;
  return number;
}

}  // namespace

Result<Attached> attach(SessionState& state, const JoinRequest& join, TimePoint now) {
  Audience& audience = state.audience;
  Attached attached;
  if (const Receiver* before = audience.of(join.participant)) {
    attached.replaced = before->connection;
    std::erase_if(audience.receivers,
                  [&](const auto& one) { return one.connection == *attached.replaced; });
  }
  if (audience.receivers.size() >= kMostReceivers) {
    return fail(ErrorCode::kTooMany, "This session is full.");
  }
  Receiver receiver;
  receiver.connection = attached.connection = ++audience.connections;
  receiver.participant = join.participant;
  receiver.name = clean_name(join.name);
  receiver.number = smallest_free_number(audience);
  receiver.link = join.link;
  receiver.viewer = join.viewer;
  receiver.may_have_slices = join.may_have_slices;
  receiver.may_download = join.may_download;
  receiver.last_progress_at = now;
  if (receiver.name.empty() && receiver.participant != kOwner) {
    // A guest keeps their number after reconnecting.
    const auto number =
        audience.guests.try_emplace(receiver.participant, audience.guests.size() + 1).first;
    receiver.name = "Guest " + std::to_string(number->second);
  }
  audience.receivers.push_back(std::move(receiver));
  return attached;
}

void detach(SessionState& state, std::uint64_t connection, TimePoint now) {
  Audience& audience = state.audience;
  const Receiver* leaving = audience.find(connection);
  if (!leaving) return;
  std::erase_if(audience.receivers, [&](const auto& one) { return one.connection == connection; });
  if (audience.receivers.empty()) state.detached_since = now;
}

void use_free_camera(SessionState& state, Receiver& receiver, bool on, TimePoint now) {
  receiver.free_camera = on;
  if (on) return;
  // Treated like a new connection, because Config resets the numbering of frames.
  receiver.flight = {};
  receiver.path = {};
  receiver.tiles_sent = 0;
  receiver.lossless_sent = false;
  receiver.sent_epoch = 0;
  receiver.shown.reset();
  receiver.converged_sent = false;
  receiver.needs_key = true;
  receiver.behind = true;
  receiver.last_progress_at = now;
  state.requested.picture_again = true;
}

void follow(SessionState& state, const v1::Scene& presenters, TimePoint now) {
  auto scene = std::make_shared<v1::Scene>(presenters);
  if (state.requested.scene) *scene->mutable_camera() = state.requested.scene->camera();
  if (state.requested.scene && MessageDifferencer::Equals(*state.requested.scene, *scene)) return;
  state.requested.scene = std::move(scene);
  state.requested.last_input = now;
  ++state.requested.version;
}

std::optional<v1::Problem> refused_request(const SessionState& state, std::uint64_t connection,
                                           const v1::ClientMessage& message) {
  const Receiver* const receiver = state.audience.find(connection);
  if (!receiver) return std::nullopt;
  if (!receiver->greeted && !message.has_hello()) return not_greeted();
  const auto request = request_of(message);
  if (!request || may(state.audience.rights(*receiver), *request)) {
    return std::nullopt;
  }
  const auto refusal = [](std::string why, std::string field) {
    return problem_of({ErrorCode::kForbidden, std::move(why), std::move(field)}, 0, false);
  };
  switch (*request) {
    case RequestKind::kScene: {
      v1::Problem problem = refusal("Only the presenter can make changes.", {});
      problem.set_input_seq(message.scene().input_seq());
      return problem;
    }
    case RequestKind::kHandover:
      return refusal("Only the presenter can hand the session over.", {});
    case RequestKind::kSlices:
      return refusal("The owner of this scan has not shared its slices.", "slices");
    case RequestKind::kKeyView:
    case RequestKind::kFile:
    case RequestKind::kFileTaken:
    case RequestKind::kFileMark:
      return refusal("You can't save videos and large pictures of this scan.", "file");
    case RequestKind::kGuestSlices:
      return refusal("Only the host of this session can show slices to guests.", "guest_slices");
    case RequestKind::kPointer:
      return refusal("The presenter has turned off the pointers of guests.", "pointer");
    case RequestKind::kMarks:
      return refusal("The presenter has turned off the marks of guests.", "marks");
    case RequestKind::kSliceView:
    case RequestKind::kMeasurements:
      return refusal("Only a presenter who can see the slices can show them.", "slice_view");
    case RequestKind::kGoodViews:
      return refusal("Only the presenter can show a tour.", "good_views");
    case RequestKind::kGuestPointers:
      return refusal("Only the presenter can turn the pointers of guests off or on.",
                     "guest_pointers");
    default:
      return refusal("You can only watch in this session.", {});
  }
}

Outcome receive(SessionState& state, std::uint64_t connection, const v1::ClientMessage& message,
                TimePoint now) {
  Receiver* const receiver = state.audience.find(connection);
  if (!receiver) return {};
  if (!receiver->greeted && !message.has_hello()) {
    Outcome outcome;
    outcome.problem = not_greeted();
    return outcome;
  }
  switch (message.body_case()) {
    case v1::ClientMessage::kHello:
      return receive_hello(state, *receiver, message.hello(), now);
    case v1::ClientMessage::kScene:
      return receive_scene(state, *receiver, message.scene(), now);
    case v1::ClientMessage::kAck:
      return receive_ack(state, *receiver, message.ack(), now);
    case v1::ClientMessage::kNeedKey:
      return receive_need_key(state, *receiver);
    case v1::ClientMessage::kVisibility:
      return receive_visibility(state, *receiver, message.visibility().visible());
    case v1::ClientMessage::kHandover:
      return receive_handover(state, *receiver, message.handover());
    case v1::ClientMessage::kFreeCamera:
      return receive_free_camera(state, *receiver, message.free_camera().on());
    case v1::ClientMessage::kDepthQuery:
      return receive_depth_query(*receiver, message.depth_query(), now);
    case v1::ClientMessage::kKernel:
      return receive_kernel_wanted(state, *receiver, now);
    case v1::ClientMessage::kErrorCurve:
      return receive_curve_query(*receiver, now);
    case v1::ClientMessage::kGoodViews:
      return receive_good_views_query(*receiver, now);
    case v1::ClientMessage::kGuestSlices:
      return receive_guest_slices(state, message.guest_slices().on());
    case v1::ClientMessage::kSliceView:
      return receive_slice_view(state, message.slice_view(), now);
    case v1::ClientMessage::kGuestPointers:
      return receive_guest_pointers(state, message.guest_pointers().on());
    case v1::ClientMessage::kRaiseHand:
      return receive_hand(state, *receiver, message.raise_hand());
    // Slices, Files and Collaboration handle these.
    case v1::ClientMessage::kSlices:
    case v1::ClientMessage::kKeyView:
    case v1::ClientMessage::kFile:
    case v1::ClientMessage::kFileTaken:
    case v1::ClientMessage::kFileMark:
    case v1::ClientMessage::kMeasurements:
    case v1::ClientMessage::kPointer:
    case v1::ClientMessage::kSharedTaken:
    case v1::ClientMessage::kMarks:
    case v1::ClientMessage::kMarkSight:
    case v1::ClientMessage::BODY_NOT_SET:
      break;
  }
  // Ignores empty messages and messages of newer pages.
  return {};
}

void began(SessionState& state, std::uint64_t epoch, const ViewRequest& requested) {
  state.epoch = epoch;
  state.shown = requested;
}

Outcome refused(SessionState& state, const ViewRequest& requested, const Error& why) {
  Outcome outcome;
  outcome.problem = problem_of(why, requested.input_seq, false);
  // A newer request that arrived meanwhile is tried on its own.
  if (state.requested.version == requested.version && state.shown.scene) {
    state.requested.scene = state.shown.scene;
    state.requested.viewport = state.shown.viewport;
  }
  state.measured_since.reset();
  return outcome;
}

std::vector<std::uint64_t> overdue_greetings(const SessionState& state, TimePoint now) {
  std::vector<std::uint64_t> overdue;
  for (const Receiver& one : state.audience.receivers) {
    if (!one.greeted && now - one.last_progress_at >= kGreetingWithin)
      overdue.push_back(one.connection);
  }
  return overdue;
}

bool watched(const SessionState& state, TimePoint now) {
  const auto& receivers = state.audience.receivers;
  return std::any_of(receivers.begin(), receivers.end(),
                     [&](const Receiver& one) { return is_watching(one, now); });
}

}  // namespace diaphane::render
