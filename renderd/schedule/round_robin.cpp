#include "renderd/schedule/round_robin.h"

#include <algorithm>

namespace diaphane::render {
namespace {

std::uint32_t samples_within(const SessionView& session, double seconds, std::uint32_t most) {
  if (session.samples == 0 || !(session.seconds_per_sample > 0)) return 1;
  const double fitting = std::min(seconds / session.seconds_per_sample, static_cast<double>(most));
  const auto doubling = static_cast<std::uint32_t>(std::min<std::uint64_t>(session.samples, most));
  return std::clamp<std::uint32_t>(static_cast<std::uint32_t>(fitting), 1, doubling);
}

}  // namespace

bool gains(const SessionView& session) {
  // An unknown error is infinite or NaN: neither is below the target.
  return session.visible && !(session.error <= session.target_error);
}

std::optional<Quantum> RoundRobin::next(std::span<const SessionView> sessions) {
  const SessionView* after = nullptr;  // the lowest handle above the last turn
  const SessionView* first = nullptr;  // the lowest handle of all: where the round begins again
  for (const SessionView& session : sessions) {
    if (!gains(session)) continue;
    if (!first || session.session < first->session) first = &session;
    if (session.session > last_ && (!after || session.session < after->session)) after = &session;
  }
  const SessionView* chosen = after ? after : first;
  if (!chosen) return std::nullopt;
  last_ = chosen->session;
  return Quantum{chosen->session,
                 samples_within(*chosen, options_.quantum_seconds, options_.max_samples)};
}

}  // namespace diaphane::render
