#include "renderd/session/saving.h"

#include <set>

namespace diaphane::render {
namespace {

SavedSession saved(const SessionState& state) {
  return {state.id,
          state.placement,
          state.requested.scene->SerializeAsString(),
          state.requested.input_seq,
          state.requested.viewport,
          state.audience.presenter,
          state.audience.guest_slices};
}

}  // namespace

std::optional<SavedSession> take_unsaved(SessionState& state) {
  if (!state.unsaved || !state.requested.scene) return std::nullopt;
  state.unsaved = false;
  return saved(state);
}

std::optional<RecoveryRecord> recovery_record(const SessionState& state, const std::string& user_id,
                                              bool visitor) {
  if (!state.requested.scene) return std::nullopt;
  std::set<std::string> links;
  for (const Receiver& receiver : state.audience.receivers) {
    if (receiver.link.empty()) continue;
    links.insert(receiver.link + (receiver.may_have_slices ? " slices" : ""));
  }
  return RecoveryRecord{
      saved(state), user_id, state.volume_id, {links.begin(), links.end()}, visitor};
}

}  // namespace diaphane::render
