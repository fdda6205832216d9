#include "renderd/session/collaboration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/annotations.h"
#include "scene/check.h"

namespace diaphane::render {
namespace {

constexpr int kPlanes = 3;

bool within(double value, double most) { return std::fabs(value) <= most; }  // false for NaN

bool is_place(const v1::Vec3& place) {
  return within(place.x(), scene::kLongestDistance) && within(place.y(), scene::kLongestDistance) &&
         within(place.z(), scene::kLongestDistance);
}

bool is_valid_tilt(const v1::SliceView::Tilt& tilt) {
  const auto is_direction = [](const v1::Vec3& one) {
    return within(one.x(), 1.001) && within(one.y(), 1.001) && within(one.z(), 1.001);
  };
  return is_direction(tilt.right()) && is_direction(tilt.down());
}

bool is_valid(const v1::SliceView& view) {
  return view.placings_size() <= kPlanes && is_place(view.crosshair()) &&
         within(view.window_centre(), 1e6) && within(view.window_width(), 1e6) &&
         within(view.overlay(), 1) && within(view.labels(), 1) &&
         within(view.slab(), scene::kLongestDistance) && view.tilts_size() <= kPlanes &&
         std::ranges::all_of(view.tilts(), is_valid_tilt) &&
         std::ranges::all_of(view.placings(), [](const v1::SliceView::Placing& one) {
           return within(one.zoom(), 1e6) && within(one.column(), 1e6) && within(one.row(), 1e6);
         });
}

Effects refused(std::uint64_t connection, std::string field) {
  return {problem_to(connection,
                     {ErrorCode::kInvalid, "The page sent an invalid view.", std::move(field)})};
}

/// Returns a copy without fields of newer pages, which would otherwise be passed on unchecked.
template <typename Message>
Message known_fields(const Message& message) {
  Message copy = message;
  copy.DiscardUnknownFields();
  return copy;
}

bool sees_slices(const Audience& audience, const Receiver& receiver) {
  return slice_access(audience.rights(receiver)) != SliceAccess::kNone;
}

}  // namespace

bool Collaboration::is_shared(const SessionState& state) {
  return state.audience.receivers.size() > 1;
}

Effects Collaboration::handle(const SliceViewSent& event, SessionState& state, TimePoint now) {
  if (!is_shared(state)) return {};
  if (!is_valid(event.view)) return refused(event.connection, "slice_view");
  view_ = {known_fields(event.view), ++version_};
  return broadcast(state, now);
}

Effects Collaboration::handle(const MeasurementsSent& event, SessionState& state, TimePoint now) {
  if (!is_shared(state)) return {};
  if (!scene::are_valid(event.measurements)) return refused(event.connection, "measurements");
  measurements_ = {known_fields(event.measurements), ++version_};
  return broadcast(state, now);
}

Effects Collaboration::handle(const PointerMoved& event, SessionState& state, TimePoint now) {
  const Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver || !is_shared(state)) return {};
  Pointer& pointer = pointers_[receiver->participant];
  pointer.allowance.refill(now);
  if (pointer.allowance.empty()) return {};
  pointer.allowance.take();
  ++pointer.moves;
  pointer.of_guest = receiver->viewer == ViewerKind::kGuest;
  pointer.shown.set_number(receiver->number);
  switch (event.move.at_case()) {
    case v1::PointerMove::kPicture: {
      const auto& at = event.move.picture();
      surfaces_.refill(now);
      if (!(at.x() >= 0 && at.x() <= 1 && at.y() >= 0 && at.y() <= 1) || surfaces_.empty()) break;
      surfaces_.take();
      return {effect::FindPointer{event.connection, pointer.moves, at.x(), at.y()}};
    }
    case v1::PointerMove::kSlice: {
      const auto& at = event.move.slice();
      if (!is_place(at.place()) || !sees_slices(state.audience, *receiver)) break;
      pointer.shown.set_plane(at.plane());
      pointer.shown.set_x(static_cast<float>(at.place().x()));
      pointer.shown.set_y(static_cast<float>(at.place().y()));
      pointer.shown.set_z(static_cast<float>(at.place().z()));
      pointer.shown.set_shown(true);
      return moved(pointer, state, now);
    }
    case v1::PointerMove::AT_NOT_SET:
      pointer.shown.set_shown(false);
      return moved(pointer, state, now);
  }
  return {};
}

Effects Collaboration::handle(const PointerFound& event, SessionState& state, TimePoint now) {
  const Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  const auto found = pointers_.find(receiver->participant);
  // A later move may have been handled meanwhile.
  if (found == pointers_.end() || found->second.moves != event.number) return {};
  auto& shown = found->second.shown;
  shown.set_plane(v1::ANATOMICAL_PLANE_UNSPECIFIED);
  shown.set_shown(event.place.has_value());
  if (event.place) {
    shown.set_x(static_cast<float>(event.place->x));
    shown.set_y(static_cast<float>(event.place->y));
    shown.set_z(static_cast<float>(event.place->z));
  }
  return moved(found->second, state, now);
}

Effects Collaboration::handle(const MarksSent& event, SessionState& state, TimePoint now) {
  const Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  if (!scene::are_valid(event.marks)) return refused(event.connection, "marks");
  MarksOf& marks = marks_[receiver->participant];
  marks.allowance.refill(now);
  if (marks.allowance.empty()) {
    return {problem_to(event.connection,
                       {ErrorCode::kTooMany, "Marks are changing too often.", "marks"})};
  }
  marks.allowance.take();
  marks.marks = scene::cleaned(event.marks);
  marks.number = receiver->number;
  marks.version = ++version_;
  return is_shared(state) ? broadcast(state, now) : Effects{};
}

Effects Collaboration::handle(const MarkSightRequested& event, const SessionState& state,
                              TimePoint now) {
  const Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver) return {};
  MarksOf& marks = marks_[receiver->participant];
  marks.number = receiver->number;
  marks.sights.refill(now);
  if (marks.sights.empty()) return {};
  marks.sights.take();
  return {effect::FindMarkSight{event.connection}};
}

std::vector<Collaboration::PlacedMark> Collaboration::placed_marks() const {
  std::vector<PlacedMark> placed;
  for (const auto& [participant, of] : marks_) {
    if (!of.shown) continue;
    for (const v1::Mark& mark : of.marks.items()) {
      const v1::Vec3& place = mark.place();
      placed.push_back({of.number, mark.id(), {place.x(), place.y(), place.z()}});
    }
  }
  return placed;
}

void Collaboration::apply_permission(const Audience& audience) {
  for (auto& [participant, of] : marks_) {
    const Receiver* const receiver = audience.of(participant);
    if (!receiver) continue;
    const bool shown = may(audience.rights(*receiver), RequestKind::kMarks);
    if (std::exchange(of.shown, shown) == shown) continue;
    of.version = ++version_;
  }
}

Effects Collaboration::handle(const SharedReceived& event, SessionState& state, TimePoint now) {
  Receiver* const receiver = state.audience.find(event.connection);
  if (!receiver || event.seq <= receiver->shared.taken || event.seq > receiver->shared.sent) {
    return {};
  }
  receiver->shared.taken = event.seq;
  Effects effects;
  send_changes(effects, state, *receiver, now);
  return effects;
}

Effects Collaboration::handle(ParticipantsChanged, SessionState& state, TimePoint now) {
  const Audience& audience = state.audience;
  const auto has_left = [&](const auto& one) { return !audience.of(one.first); };
  std::erase_if(pointers_, has_left);
  std::erase_if(marks_, has_left);
  apply_permission(audience);
  const Receiver* const presenter = audience.of(audience.presenter);
  // Closes the slices of a previous presenter, which the new one has no access to.
  if (presenter && view_.version != 0 && !sees_slices(audience, *presenter)) {
    view_ = {{}, ++version_};
    measurements_ = {{}, ++version_};
  }
  if (!is_shared(state)) return {};
  return broadcast(state, now);
}

Effects Collaboration::moved(Pointer& pointer, SessionState& state, TimePoint now) {
  pointer.version = ++version_;
  pointer.moved_at = now;
  return broadcast(state, now);
}

Effects Collaboration::broadcast(SessionState& state, TimePoint now) const {
  Effects effects;
  for (Receiver& receiver : state.audience.receivers) send_changes(effects, state, receiver, now);
  return effects;
}

void Collaboration::send_changes(Effects& effects, const SessionState& state, Receiver& receiver,
                                 TimePoint now) const {
  SharedWindow& window = receiver.shared;
  if (!receiver.greeted || window.sent - window.taken >= kMostUnderWay) return;
  const Audience& audience = state.audience;
  effect::Send send{receiver.connection, {}};
  v1::SharedState& shared = *send.message.mutable_shared();
  const bool slices = sees_slices(audience, receiver);
  if (!slices) {
    window.slices_seen = 0;  // if access is given later, everything is sent
  } else if (!audience.presents(receiver)) {
    if (view_.version > window.slices_seen) *shared.mutable_slice_view() = view_.message;
    if (measurements_.version > window.slices_seen) {
      *shared.mutable_measurements() = measurements_.message;
    }
    window.slices_seen = version_;
  }
  for (const auto& [participant, pointer] : pointers_) {
    const bool of_slice = pointer.shown.plane() != v1::ANATOMICAL_PLANE_UNSPECIFIED;
    if (pointer.version <= window.pointers_seen || participant == receiver.participant ||
        now - pointer.moved_at > kPointerFor ||
        (pointer.of_guest && !audience.guest_pointers && participant != audience.presenter)) {
      continue;
    }
    v1::SharedState::Pointer& shown = *shared.add_pointers();
    if (of_slice && !slices) {
      shown.set_number(pointer.shown.number());  // no place in the picture, because the pointer is
                                                 // in a slice
    } else {
      shown = pointer.shown;
    }
  }
  window.pointers_seen = version_;
  add_marks(shared, receiver);
  if (!shared.has_slice_view() && !shared.has_measurements() && shared.pointers_size() == 0 &&
      shared.marks_size() == 0) {
    return;
  }
  shared.set_seq(++window.sent);
  effects.emplace_back(std::move(send));
}

void Collaboration::add_marks(v1::SharedState& shared, Receiver& receiver) const {
  for (const auto& [participant, of] : marks_) {
    if (of.version <= receiver.shared.marks_seen || participant == receiver.participant) continue;
    v1::SharedState::ParticipantMarks& marks = *shared.add_marks();
    marks.set_number(of.number);
    marks.mutable_marks();
    if (of.shown) *marks.mutable_marks() = of.marks;
  }
  receiver.shared.marks_seen = version_;
}

}  // namespace diaphane::render
