#include "api/presets/recordings.h"

#include "common/ids.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_recording() {
  return refuse(ProblemKind::kNotFound, "Recording not found.");
}

template <typename T>
Outcome<T> answer(Result<T> result) {
  if (result) {
    if constexpr (std::is_void_v<T>)
      return {};
    else
      return *std::move(result);
  }
  if (result.error().code == ErrorCode::kNotFound) return no_such_recording();
  return refuse(result.error());
}

}  // namespace

Outcome<Recordings::Mine> Recordings::list(const Principal& who) {
  const auto consent = store_.consent(who.user_id);
  if (!consent) return refuse(consent.error());
  auto recordings = store_.of(who.user_id, clock_.wall());
  if (!recordings) return refuse(recordings.error());
  return Mine{*consent, *std::move(recordings)};
}

Outcome<void> Recordings::give_consent(const Principal& who, bool given) {
  return answer(store_.set_consent(who.user_id, given, clock_.wall()));
}

Outcome<std::string> Recordings::add(const Principal& who, Recording recording) {
  recording.id = new_id();
  recording.created_at = clock_.wall();
  recording.expires_at = recording.created_at + kLife;
  const auto added = store_.add(who.user_id, recording, kMostBytes);
  if (added) return recording.id;
  return refuse(added.error());
}

Outcome<Recording> Recordings::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_recording();
  return answer(store_.find(who.user_id, id, clock_.wall()));
}

Outcome<void> Recordings::remove(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_recording();
  return answer(store_.remove(who.user_id, id));
}

}  // namespace diaphane::api
