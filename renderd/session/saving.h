#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderd/session/state.h"

namespace diaphane::render {

/// State in Redis from which another worker can resume the session.
struct SavedSession {
  std::string id;
  std::uint64_t placement = 0;
  std::string scene;  ///< serialised
  std::uint64_t input_seq = 0;
  Canvas viewport;
  std::string presenter;  ///< a participant
  bool guest_slices = false;
};

/// State from which the session is restored in Redis after Redis has lost all data.
struct RecoveryRecord {
  SavedSession saved;
  std::string user_id;
  std::string volume_id;
  std::vector<std::string> links;  ///< links by which guests joined, as in directory::LostSession
  bool visitor = false;
  std::string over = {}, to_first = {};  ///< the second scan, as in directory::PlaceRequest
};

/// Returns the state to save if Redis has an older one, and marks it as saved.
std::optional<SavedSession> take_unsaved(SessionState& state);
/// Returns nullopt until a scene is set. `visitor`: the user has no account.
std::optional<RecoveryRecord> recovery_record(const SessionState& state, const std::string& user_id,
                                              bool visitor);

}  // namespace diaphane::render
