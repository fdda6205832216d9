#include "renderd/schedule/round_robin.h"

#include <algorithm>

namespace diaphane::render {
namespace {

// At least one sample; as many as fit, but no more than `most`.
std::uint32_t samples_within(double seconds, double seconds_per_sample, std::uint64_t most) {
  if (!(seconds_per_sample > 0)) return 1;
  const double fitting = std::min(seconds / seconds_per_sample, static_cast<double>(most));
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(fitting), 1);
}

}  // namespace

bool gains(const SessionView& session) {
  // An unknown error is infinite or NaN: neither is below the target.
  return session.visible && !(session.error <= session.target_error);
}

std::optional<Quantum> RoundRobin::next(std::span<const SessionView> sessions) {
  const SessionView* after = nullptr;   // the lowest handle above the last turn
  const SessionView* lowest = nullptr;  // of all: where the round begins again
  for (const SessionView& session : sessions) {
    if (!gains(session)) continue;
    if (!lowest || session.session < lowest->session) lowest = &session;
    if (session.session > last_ && (!after || session.session < after->session)) after = &session;
  }
  const SessionView* chosen = after ? after : lowest;
  if (!chosen) return std::nullopt;
  last_ = chosen->session;
  const bool first = chosen->samples == 0;
  const std::uint64_t most = options_.max_samples;
  return Quantum{
      chosen->session,
      samples_within(first ? options_.first_seconds : options_.quantum_seconds,
                     chosen->seconds_per_sample, first ? most : std::min(chosen->samples, most))};
}

}  // namespace diaphane::render
