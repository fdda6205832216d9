#include "renderd/session/audience.h"

#include <algorithm>

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
  rights.slices = receiver.viewer == ViewerKind::kGuest
                      ? guest_slices && (rights.presents || (slices_shown && of(presenter)))
                      : receiver.may_have_slices;
  rights.pointers = guest_pointers;
  return rights;
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
