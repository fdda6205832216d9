#include "renderd/session/audience.h"

#include <algorithm>
#include <cmath>

#include "common/names.h"

namespace diaphane::render {

Receiver* Audience::find(std::uint64_t connection) {
  const auto found = std::find_if(receivers.begin(), receivers.end(),
                                  [&](const auto& one) { return one.connection == connection; });
  return found == receivers.end() ? nullptr : &*found;
}

const Receiver* Audience::find(std::uint64_t connection) const {
  return const_cast<Audience*>(this)->find(connection);
}

Receiver* Audience::of(std::string_view participant) {
  const auto found = std::find_if(receivers.begin(), receivers.end(),
                                  [&](const auto& one) { return one.participant == participant; });
  return found == receivers.end() ? nullptr : &*found;
}

const Receiver* Audience::of(std::string_view participant) const {
  return const_cast<Audience*>(this)->of(participant);
}

ViewerRights Audience::rights(const Receiver& receiver) const {
  ViewerRights rights;
  rights.viewer = receiver.viewer;
  rights.presents = presents(receiver);
  rights.free_camera = receiver.free_camera;
  rights.pointers = guest_pointers;
  rights.slices = receiver.may_have_slices;
  if (receiver.viewer == ViewerKind::kGuest) {
    rights.any_slice = receiver.may_have_slices;
    // A guest with a camera of their own does not follow the presenter's slices.
    const bool follows = shows_slices() && of(presenter) && !receiver.free_camera;
    if (guest_slices && (rights.presents || follows)) rights.slices = true;
  }
  rights.downloads = receiver.may_download;
  return rights;
}

bool ShownSlices::contains(const volume::SliceStack& stack, std::uint32_t index) const {
  const bool has_plane = layout == v1::SliceView::FOUR ||
                         (layout == v1::SliceView::SLICE && plane == to_proto(stack.plane));
  if (!has_plane) return false;
  double along = 0, square = 0;
  for (std::size_t i = 0; i < crosshair.size(); ++i) {
    along += (crosshair[i] - stack.first[i]) * stack.next[i];
    square += stack.next[i] * stack.next[i];
  }
  // Between two slices, pages may round either way.
  constexpr double kHalf = 0.5 + 1e-6;
  const double exact = std::clamp(along / square, 0.0, double(stack.slices) - 1);
  return std::fabs(exact - double(index)) <= kHalf;  // false for NaN
}

void Audience::show(const v1::SliceView& view, TimePoint now) {
  if (shows_slices()) {
    slices_before.push_back(slices_shown);
    slices_before.back().until = now + kShownBefore;
    if (slices_before.size() > kMostShownBefore) slices_before.pop_front();
  }
  const v1::Vec3& place = view.crosshair();
  slices_shown = {view.layout(), view.plane(), {place.x(), place.y(), place.z()}, {}};
  if (!shows_slices()) slices_before.clear();
}

bool Audience::shows(const volume::SliceStack& stack, std::uint32_t index, TimePoint now) const {
  return slices_shown.contains(stack, index) ||
         std::ranges::any_of(slices_before, [&](const ShownSlices& before) {
           return now < before.until && before.contains(stack, index);
         });
}

namespace {
/// Returns the place among the raised hands, from 1, or 0 if the hand is not raised.
std::uint32_t place_in_queue(const Audience& audience, const Receiver& receiver) {
  if (receiver.hand == 0) return 0;
  return static_cast<std::uint32_t>(
      std::ranges::count_if(audience.receivers, [&](const Receiver& one) {
        return one.greeted && one.hand != 0 && one.hand <= receiver.hand;
      }));
}
}  // namespace

bool is_inter_coded(v1::Codec codec) { return codec != v1::JPEG; }

std::string clean_name(std::string_view typed) { return diaphane::clean_name(typed, kLongestName); }

bool has_room(const Receiver& receiver) {
  return receiver.flight.room() &&
         receiver.path.bytes_in_flight() < receiver.quality.plan().window_bytes;
}

bool is_watching(const Receiver& receiver, TimePoint now) {
  if (!receiver.greeted || !receiver.visible || receiver.free_camera) return false;
  return receiver.flight.unacknowledged() == 0 || now - receiver.last_progress_at < kStalledAfter;
}

Result<void> hand_over(Audience& audience, const Receiver& from, std::string_view to) {
  Receiver* const next = audience.of(to);
  if (!next || !next->greeted) {
    return fail(ErrorCode::kNotFound, "That person has left the session.", "to");
  }
  if (next->free_camera) {
    return fail(ErrorCode::kConflict, "That person is using their own camera.", "to");
  }
  // The scan is the owner's, so nobody can keep control of it against their will.
  const bool takes_back = from.participant == kOwner && to == kOwner;
  if (!audience.presents(from) && !takes_back) {
    return fail(ErrorCode::kForbidden, "Only the presenter can hand the session over.");
  }
  audience.presenter = to;
  next->hand = 0;
  return {};
}

v1::Audience audience_for(const Audience& audience, const Receiver& receiver) {
  v1::Audience message;
  message.set_you(receiver.participant);
  message.set_presenter(audience.presenter);
  const ViewerRights rights = audience.rights(receiver);
  message.set_slices(to_proto(slice_access(rights)));
  message.set_guest_slices(audience.guest_slices);
  message.set_guest_pointers(audience.guest_pointers);
  message.set_downloads(may(rights, RequestKind::kFile));
  message.set_sets_guest_slices(may(rights, RequestKind::kGuestSlices));
  for (const Receiver& one : audience.receivers) {
    if (!one.greeted) continue;
    v1::Participant& participant = *message.add_participants();
    participant.set_id(one.participant);
    participant.set_name(one.name);
    participant.set_owner(one.participant == kOwner);
    participant.set_presenter(audience.presents(one));
    participant.set_free_camera(one.free_camera);
    participant.set_number(one.number);
    participant.set_hand(place_in_queue(audience, one));
  }
  return message;
}

}  // namespace diaphane::render
