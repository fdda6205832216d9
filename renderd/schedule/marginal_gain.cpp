#include "renderd/schedule/marginal_gain.h"

#include <algorithm>
#include <cmath>

namespace diaphane::render {
namespace {

/// Seconds per sample assumed for a session that was not measured: those of a slow GPU.
constexpr double kUnknownCost = 0.001;

double cost_of(const SessionView& session) {
  return session.seconds_per_sample > 0 ? session.seconds_per_sample : kUnknownCost;
}

enum class Rank { kDue, kGaining, kPaced };

struct Candidate {
  Rank rank = Rank::kPaced;
  double key = 0;  // smaller keys come first
  const SessionView* session = nullptr;

  bool before(const Candidate& other) const {
    if (rank != other.rank) return rank < other.rank;
    if (key != other.key) return key < other.key;
    return session->session < other.session->session;
  }
};

/// The load from all sessions together.
struct Load {
  std::size_t gaining = 0;
  std::size_t moving = 0;
  double first_frames = 0;  // seconds for one frame of each moving session
};

double frame_cost(const SessionView& session) { return session.seconds_first + cost_of(session); }

Load load_of(std::span<const SessionView> sessions, double moving_seconds) {
  Load load;
  for (const SessionView& session : sessions) {
    if (!gains(session)) continue;
    ++load.gaining;
    if (session.seconds_since_input >= moving_seconds) continue;
    ++load.moving;
    load.first_frames += frame_cost(session);
  }
  return load;
}

/// Returns the largest share of the device that one drag may take so that all drags together take
/// `budget`. No drag takes more than it needs for a frame every `frame_seconds` (max-min fairness).
/// Requires that all drags together need more than `budget`.
double fair_drag_share(std::span<const SessionView> sessions, double moving_seconds,
                       double frame_seconds, double budget) {
  double share = 0;
  for (;;) {
    double left = budget;
    std::size_t limited = 0;
    for (const SessionView& session : sessions) {
      if (!gains(session) || session.seconds_since_input >= moving_seconds) continue;
      const double full_share = frame_cost(session) / frame_seconds;
      if (full_share <= share) {
        left -= full_share;
      } else {
        ++limited;
      }
    }
    // Each iteration raises the share, so that it covers the need of at least one more session, or
    // ends.
    const double next = limited == 0 ? share : left / static_cast<double>(limited);
    if (next <= share) return share;
    share = next;
  }
}

}  // namespace

double MarginalGain::gain(const SessionView& session) const {
  const double n = static_cast<double>(session.samples);
  const double m = quantum_samples(session, options_.limits);
  const double cost = cost_of(session);
  // Before the first sample nothing is shown, so the error is 1. Before the second no error can be
  // estimated, so the previous picture's noise is used.
  const double noise = session.noise > 0 ? std::min(session.noise, 1.0) : 1.0;
  double error = 1;
  if (session.samples > 0) {
    error = std::isfinite(session.error) ? session.error : noise / std::sqrt(n);
  }
  const double after =
      session.samples > 0 ? error * std::sqrt(n / (n + m)) : noise / std::sqrt(1 + m);
  double per_second =
      (error - after) / (m * cost + (session.samples > 0 ? 0 : session.seconds_first));
  if (session.samples > 0 && error > options_.usable_error) {
    const double ratio = error / options_.usable_error;
    const double left = std::max(n * (ratio * ratio - 1), 1.0);  // samples until it is usable
    per_second = std::max(per_second,
                          (error - options_.usable_error + options_.usable_worth) / (left * cost));
  }
  const double stay =
      options_.stay_growth * (session.seconds_since_input - options_.silence_seconds);
  return per_second * std::clamp(stay, options_.shortest_stay, options_.longest_stay);
}

std::vector<Quantum> MarginalGain::next(std::span<const SessionView> sessions) {
  return choose(sessions, std::nullopt);
}

std::vector<Quantum> MarginalGain::overtaking(std::span<const SessionView> sessions,
                                              unsigned highest) {
  return choose(sessions, highest);
}

// A user who ends a drag waits for the picture just as much as during the drag. The limit keeps a
// session whose inputs never end from stopping all others, because only drags are paced.
bool MarginalGain::may_overtake(const SessionView& session, unsigned above) const {
  if (session.samples > 0 || first_picture_precedence(session) <= above) return false;
  if (session.seconds_since_input < options_.moving_seconds) return true;
  return session.seconds_unanswered > 0 && session.seconds_lately < options_.most_drag_share;
}

std::vector<Quantum> MarginalGain::choose(std::span<const SessionView> sessions,
                                          std::optional<unsigned> above) const {
  const Load load = load_of(sessions, options_.moving_seconds);
  const double slowest = options_.slowest_frame_seconds;
  const double frame_seconds = std::min(load.first_frames / options_.drag_share, slowest);
  const double drag_share =
      load.first_frames > options_.most_drag_share * slowest
          ? fair_drag_share(sessions, options_.moving_seconds, slowest, options_.most_drag_share)
          : 1;
  // A moving session can be held back this long, because a quantum begun now may still delay it by
  // its own length.
  const double spare = options_.deadline_seconds - options_.limits.quantum_seconds;
  const double patience = std::max(
      options_.patience_seconds,
      static_cast<double>(load.gaining) * options_.limits.least_seconds / options_.patience_share);
  const auto candidate = [&](const SessionView& session) -> Candidate {
    if (session.seconds_waiting >= patience) {
      return {Rank::kDue, patience - session.seconds_waiting, &session};
    }
    if (session.samples == 0 && session.seconds_unanswered > 0 && session.wants_frame) {
      const double rationed = frame_cost(session) / drag_share;
      const bool keeps_deadline = rationed <= slowest;
      if (session.seconds_since_begun < std::max(rationed, frame_seconds) &&
          (!keeps_deadline || session.seconds_unanswered < spare)) {
        return {Rank::kPaced, -session.seconds_since_begun, &session};
      }
      // Device time for recent first pictures postpones a deadline, as in fair queueing.
      const double deadline = options_.deadline_seconds + session.seconds_lately;
      return {Rank::kDue, deadline - session.seconds_unanswered, &session};
    }
    return {Rank::kGaining, -gain(session), &session};
  };

  Candidate best;
  for (const SessionView& session : sessions) {
    if (!waits(session)) continue;
    if (above && !may_overtake(session, *above)) continue;
    const Candidate other = candidate(session);
    if (above && other.rank != Rank::kDue) continue;
    if (!best.session || other.before(best)) best = other;
  }
  if (!best.session) return {};
  // The first pictures of all drags share the time that one drag alone would get. A picture that
  // will stay is worth its second sample, from which its error is estimated.
  QuantumLimits limits = limits_for(sessions, options_.limits);
  if (best.session->seconds_since_input < options_.moving_seconds) {
    limits.first_seconds /= static_cast<double>(std::max<std::size_t>(load.moving, 1));
  }
  std::uint32_t samples = quantum_samples(*best.session, limits);
  if (best.session->seconds_waiting >= patience) {
    samples = std::min(
        samples, samples_within(limits.least_seconds, best.session->seconds_per_sample, samples));
  }
  return {{best.session->session, samples}};
}

}  // namespace diaphane::render
