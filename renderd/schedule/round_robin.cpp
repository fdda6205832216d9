#include "renderd/schedule/round_robin.h"

namespace diaphane::render {

std::vector<Quantum> RoundRobin::next(std::span<const SessionView> sessions) {
  const SessionView* after = nullptr;  // the session with the lowest handle above the last one
  // The session with the lowest handle, with which a new round begins.
  const SessionView* lowest = nullptr;
  for (const SessionView& session : sessions) {
    if (!waits(session)) continue;
    if (!lowest || session.session < lowest->session) lowest = &session;
    if (session.session > last_ && (!after || session.session < after->session)) after = &session;
  }
  const SessionView* chosen = after ? after : lowest;
  if (!chosen) return {};
  last_ = chosen->session;
  return {{chosen->session, quantum_samples(*chosen, limits_for(sessions, limits_))}};
}

}  // namespace diaphane::render
