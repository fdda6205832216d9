#pragma once

#include <mutex>
#include <type_traits>
#include <utility>
#include <variant>

#include "renderd/serve/live_session.h"

namespace diaphane::render {

/// Whether an effect is carried out under the lock, because it only sends to viewers.
template <typename One>
inline constexpr bool kSendsOnly =
    std::is_same_v<One, effect::Send> || std::is_same_v<One, effect::Configure> ||
    std::is_same_v<One, effect::BroadcastParticipants>;

/// One event of a session. Holds the lock while the rules decide, and carries out what they asked
/// for once it has released the lock.
class LiveSession::Turn {
 public:
  explicit Turn(LiveSession& session)
      : session_(session), lock_(session.mutex_), now(session.parts_.clock.now()) {}
  ~Turn() {
    Effects effects = std::exchange(session_.pending_, {});
    lock_.unlock();
    for (Effect& one : effects) {
      std::visit(
          [this](auto& asked) {
            if constexpr (!kSendsOnly<std::decay_t<decltype(asked)>>) session_.carry_out(asked);
          },
          one);
    }
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  LiveSession& session_;
  std::unique_lock<std::mutex> lock_;

 public:
  const TimePoint now;
};

}  // namespace diaphane::render
