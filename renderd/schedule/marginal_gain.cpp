#include "renderd/schedule/marginal_gain.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render {
namespace {

/// Before anybody knows a session's cost, that of a picture of a slow GPU.
constexpr double kUnknownCost = 0.001;

double cost_of(const SessionView& session) {
  return session.seconds_per_sample > 0 ? session.seconds_per_sample : kUnknownCost;
}

enum class Rank { kDue, kGaining, kPaced };

struct Candidate {
  Rank rank = Rank::kPaced;
  double key = 0;  // the smaller first
  const SessionView* session = nullptr;

  bool before(const Candidate& other) const {
    if (rank != other.rank) return rank < other.rank;
    if (key != other.key) return key < other.key;
    return session->session < other.session->session;
  }
};

/// What all sessions together say about the load.
struct Load {
  std::size_t gaining = 0;
  std::size_t moving = 0;
  double first_frames = 0;  // seconds that one frame of each moving session takes
};

Load load_of(std::span<const SessionView> sessions, double moving_seconds) {
  Load load;
  for (const SessionView& session : sessions) {
    if (!gains(session)) continue;
    ++load.gaining;
    if (session.seconds_since_input >= moving_seconds) continue;
    ++load.moving;
    load.first_frames += session.seconds_first + cost_of(session);
  }
  return load;
}

}  // namespace

double MarginalGain::gain(const SessionView& session) const {
  const double n = static_cast<double>(session.samples);
  const double m = quantum_samples(session, options_.limits);
  const double cost = cost_of(session);
  // Nothing is shown before the first sample, and before the second no error is known but that of
  // the picture before.
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
    const double left = std::max(n * (ratio * ratio - 1), 1.0);  // samples until it can be read
    per_second = std::max(per_second,
                          (error - options_.usable_error + options_.usable_worth) / (left * cost));
  }
  const double stay =
      options_.stay_growth * (session.seconds_since_input - options_.silence_seconds);
  return per_second * std::clamp(stay, options_.shortest_stay, options_.longest_stay);
}

std::vector<Quantum> MarginalGain::next(std::span<const SessionView> sessions) {
  const Load load = load_of(sessions, options_.moving_seconds);
  const double slowest = options_.slowest_frame_seconds;
  const double rationed = load.first_frames / options_.most_drag_share;
  const double frame_seconds =
      std::max(rationed, std::min(load.first_frames / options_.drag_share, slowest));
  // As long a moving session can be held back: a quantum begun now may still come before it.
  const double spare = rationed > slowest
                           ? std::numeric_limits<double>::infinity()
                           : options_.deadline_seconds - options_.limits.quantum_seconds;
  const double patience = std::max(
      options_.patience_seconds,
      static_cast<double>(load.gaining) * options_.limits.least_seconds / options_.patience_share);
  const auto candidate = [&](const SessionView& session) -> Candidate {
    if (session.seconds_waiting >= patience) {
      return {Rank::kDue, patience - session.seconds_waiting, &session};
    }
    if (session.samples == 0 && session.seconds_unanswered > 0 && session.wants_frame) {
      if (session.seconds_since_begun < frame_seconds && session.seconds_unanswered < spare) {
        return {Rank::kPaced, -session.seconds_since_begun, &session};
      }
      return {Rank::kDue, options_.deadline_seconds - session.seconds_unanswered, &session};
    }
    return {Rank::kGaining, -gain(session), &session};
  };

  Candidate best;
  for (const SessionView& session : sessions) {
    if (!waits(session)) continue;
    const Candidate other = candidate(session);
    if (!best.session || other.before(best)) best = other;
  }
  if (!best.session) return {};
  // The first pictures of drags share what one alone would take. One that will stay is worth its
  // second sample, which tells its error.
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
