#include "renderd/session/audience.h"

#include <algorithm>

namespace diaphane::render {
namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: no valid UTF-8 here
};

Character decode(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (length == 0 || first > 0xf4 || text.size() < length) return {};
  char32_t code = first & (0x7f >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = (code << 6) | (byte(i) & 0x3f);
  }
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kSmallest[length] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
  return {code, length};
}

bool is_space(char32_t c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == 0xa0 || c == 0x1680 ||
         (c >= 0x2000 && c <= 0x200a) || c == 0x2028 || c == 0x2029 || c == 0x202f || c == 0x205f ||
         c == 0x3000;
}

// What has no picture of its own, or changes how its neighbours are shown: it would let one name
// pass for another.
bool is_hidden(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0xad || c == 0x61c || c == 0x180e ||
         (c >= 0x200b && c <= 0x200f) || (c >= 0x202a && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0xfeff || (c >= 0xfff0 && c <= 0xffff) ||
         (c >= 0xe000 && c <= 0xf8ff) || c >= 0xe0000;
}

}  // namespace

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

bool is_inter_coded(v1::Codec codec) { return codec != v1::JPEG; }

std::string clean_name(std::string_view typed) {
  std::string name;
  bool space = false;
  for (std::size_t characters = 0; !typed.empty() && characters < kLongestName;) {
    const Character next = decode(typed);
    const std::string_view bytes = typed.substr(0, std::max<std::size_t>(next.bytes, 1));
    typed.remove_prefix(bytes.size());
    if (next.bytes == 0) continue;
    if (is_space(next.code)) {
      space = !name.empty();
      continue;
    }
    if (is_hidden(next.code)) continue;
    if (space) {
      if (++characters == kLongestName) break;
      name += ' ';
    }
    space = false;
    name += bytes;
    ++characters;
  }
  return name;
}

bool has_room(const Receiver& receiver) {
  return receiver.flight.room() &&
         receiver.path.bytes_in_flight() < receiver.quality.plan().window_bytes;
}

bool is_watching(const Receiver& receiver, TimePoint now) {
  if (!receiver.greeted || !receiver.visible || receiver.own_camera) return false;
  return receiver.flight.unacknowledged() == 0 || now - receiver.heard_at < kStalledAfter;
}

Result<void> hand_over(Audience& audience, const Receiver& from, std::string_view to,
                       TimePoint now) {
  const Receiver* next = audience.of(to);
  if (!next || !next->greeted) {
    return fail(ErrorCode::kNotFound, "That person is not here any more.", "to");
  }
  if (next->own_camera) {
    return fail(ErrorCode::kConflict, "That person looks with a camera of their own.", "to");
  }
  const bool orphaned =
      !audience.of(audience.presenter) && now - audience.presenter_left >= kPresenterAway;
  const bool takes = from.participant == kOwner && to == kOwner && orphaned;
  if (!audience.presents(from) && !takes) {
    return fail(ErrorCode::kForbidden, from.participant == kOwner
                                           ? "The presenter is here, or may be back in a moment."
                                           : "Only the presenter can hand the session over.");
  }
  audience.presenter = to;
  return {};
}

v1::Audience audience_for(const Audience& audience, const Receiver& receiver) {
  v1::Audience message;
  message.set_you(receiver.participant);
  message.set_presenter(audience.presenter);
  for (const Receiver& one : audience.receivers) {
    if (!one.greeted) continue;
    v1::Participant& participant = *message.add_participants();
    participant.set_id(one.participant);
    participant.set_name(one.name);
    participant.set_owner(one.participant == kOwner);
    participant.set_presenter(audience.presents(one));
    participant.set_own_camera(one.own_camera);
  }
  return message;
}

}  // namespace diaphane::render
