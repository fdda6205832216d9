#include "renderd/schedule/error_proportional.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render {
namespace {

/// Returns pseudo-random bits: SplitMix64 (Steele, Lea, Flood 2014), a bijection.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Maps random bits to a number in (0, 1).
double uniform(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

}  // namespace

std::vector<Quantum> ErrorProportional::next(std::span<const SessionView> sessions) {
  const SessionView* winner = nullptr;
  double first = std::numeric_limits<double>::infinity();
  const std::uint64_t draw = mixed(seed_ ^ mixed(draws_));
  for (const SessionView& session : sessions) {
    if (!waits(session)) continue;
    const double n = static_cast<double>(std::max<std::uint64_t>(session.samples, 1));
    const double time = -std::log(uniform(mixed(draw ^ mixed(session.session)))) * std::sqrt(n);
    if (winner && (time > first || (time == first && session.session > winner->session))) continue;
    first = time;
    winner = &session;
  }
  if (!winner) return {};
  ++draws_;
  return {{winner->session, quantum_samples(*winner, limits_for(sessions, limits_))}};
}

}  // namespace diaphane::render
