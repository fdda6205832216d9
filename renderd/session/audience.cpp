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

namespace {

double scalar_product(const volume::Vector& a, const volume::Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

volume::Vector to_first(const volume::Vector& place, const volume::Vector& first) {
  return {place[0] - first[0], place[1] - first[1], place[2] - first[2]};
}

// Between two slices, pages may round either way.
constexpr double kHalf = 0.5 + 1e-6;

}  // namespace

bool ShownSlices::contains(const volume::SliceStack& stack, const SliceDue& due) const {
  if (due.curved) return false;  // presenters do not share their curve
  const bool has_plane = layout == v1::SliceView::FOUR ||
                         (layout == v1::SliceView::SLICE && plane == to_proto(stack.plane));
  if (!has_plane) return false;
  const bool is_oblique = !normals.empty() || slab > 0;
  if (is_oblique != due.oblique.has_value()) return false;
  if (due.oblique) return contains(stack, *due.oblique);
  const double along = scalar_product(to_first(crosshair, stack.first), stack.next) /
                       scalar_product(stack.next, stack.next);
  const double exact = std::clamp(along, 0.0, double(stack.slices) - 1);
  return std::fabs(exact - double(due.index)) <= kHalf;  // false for NaN
}

bool ShownSlices::contains(const volume::SliceStack& stack,
                           const volume::ObliqueSlice& slice) const {
  constexpr double kSame = 1e-6;
  if (slice.projection != projection || !(std::fabs(slice.thickness - slab) <= kSame)) return false;
  const auto tilted = normals.find(to_proto(stack.plane));
  const double spacing = std::sqrt(scalar_product(stack.next, stack.next));
  volume::Vector normal = stack.next;
  for (double& entry : normal) entry /= spacing;
  if (tilted != normals.end()) normal = tilted->second;
  // The angle between the normals moves the edge of the slice by less than a micrometre.
  if (!(std::fabs(scalar_product(normal, volume::normal_of(slice))) >= 1 - 1e-13)) return false;
  double step = spacing;  // of oblique slices, as pages choose it
  for (const auto& side : {stack.right, stack.down}) {
    step = std::min(step, std::sqrt(scalar_product(side, side)));
  }
  return std::fabs(scalar_product(to_first(crosshair, slice.first), normal)) <= kHalf * step;
}

void Audience::show(const v1::SliceView& view, TimePoint now) {
  if (shows_slices()) {
    slices_before.push_back(slices_shown);
    slices_before.back().until = now + kShownBefore;
    if (slices_before.size() > kMostShownBefore) slices_before.pop_front();
  }
  const v1::Vec3& place = view.crosshair();
  slices_shown = {};
  slices_shown.layout = view.layout();
  slices_shown.plane = view.plane();
  slices_shown.crosshair = {place.x(), place.y(), place.z()};
  slices_shown.slab = view.slab();
  slices_shown.projection = projection_of(view.projection());
  for (const v1::SliceView::Tilt& tilt : view.tilts()) {
    volume::ObliqueSlice plane;
    plane.right = {tilt.right().x(), tilt.right().y(), tilt.right().z()};
    plane.down = {tilt.down().x(), tilt.down().y(), tilt.down().z()};
    slices_shown.normals[tilt.plane()] = volume::normal_of(plane);
  }
  if (!shows_slices()) slices_before.clear();
}

bool Audience::shows(const volume::SliceStack& stack, const SliceDue& due, TimePoint now) const {
  return slices_shown.contains(stack, due) ||
         std::ranges::any_of(slices_before, [&](const ShownSlices& before) {
           return now < before.until && before.contains(stack, due);
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
