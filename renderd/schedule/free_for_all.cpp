#include "renderd/schedule/free_for_all.h"

#include <algorithm>

namespace diaphane::render {

std::vector<Quantum> FreeForAll::next(std::span<const SessionView> sessions) {
  std::vector<Quantum> all;
  for (const SessionView& session : sessions) {
    if (waits(session))
      all.push_back({session.session, quantum_samples(session, limits_for(sessions, limits_))});
  }
  std::sort(all.begin(), all.end(),
            [](const Quantum& a, const Quantum& b) { return a.session < b.session; });
  return all;
}

}  // namespace diaphane::render
