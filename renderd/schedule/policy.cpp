#include "renderd/schedule/policy.h"

#include <algorithm>

#include "renderd/schedule/error_proportional.h"
#include "renderd/schedule/free_for_all.h"
#include "renderd/schedule/marginal_gain.h"
#include "renderd/schedule/round_robin.h"

namespace diaphane::render {

namespace {

/// Two drags in quick succession are less than this apart.
constexpr double kCalmAfterSeconds = 0.5;

}  // namespace

bool gains(const SessionView& session) {
  // An unknown error is infinite or NaN, neither of which is below the target.
  return session.visible && !(session.error <= session.target_error);
}

bool waits(const SessionView& session) { return gains(session) && !session.under_way; }

unsigned first_picture_precedence(const SessionView& session) {
  const double seconds =
      session.seconds_first + session.seconds_per_sample + session.seconds_lately;
  unsigned precedence = 1;
  for (double least = 0.25; precedence < kHighestPrecedence && seconds > 0 && seconds < least;
       least /= 4) {
    ++precedence;
  }
  return precedence;
}

std::uint32_t samples_within(double seconds, double seconds_per_sample, std::uint64_t most) {
  if (!(seconds_per_sample > 0)) return 1;
  const double fitting = std::min(seconds / seconds_per_sample, static_cast<double>(most));
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(fitting), 1);
}

QuantumLimits limits_for(std::span<const SessionView> sessions, const QuantumLimits& limits) {
  for (const SessionView& session : sessions) {
    const bool moved = session.seconds_since_input < kCalmAfterSeconds;
    if (session.visible && (moved || session.spare)) return limits;
  }
  QuantumLimits calm = limits;
  calm.quantum_seconds = std::max(limits.quantum_seconds, limits.calm_seconds);
  return calm;
}

std::uint32_t quantum_samples(const SessionView& session, const QuantumLimits& limits) {
  const double cost = session.seconds_per_sample;
  if (session.samples == 0) return samples_within(limits.first_seconds, cost, limits.max_samples);
  const std::uint32_t fitting = samples_within(limits.quantum_seconds, cost, limits.max_samples);
  const std::uint32_t least = samples_within(limits.least_seconds, cost, limits.max_samples);
  const std::uint64_t doubling = std::max<std::uint64_t>(session.samples, least);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(fitting, doubling));
}

std::string_view policy_name(PolicyKind kind) {
  switch (kind) {
    case PolicyKind::kMarginalGain:
      return "marginal-gain";
    case PolicyKind::kErrorProportional:
      return "error-proportional";
    case PolicyKind::kRoundRobin:
      return "round-robin";
    case PolicyKind::kFreeForAll:
      return "free-for-all";
  }
  return "";
}

std::optional<PolicyKind> policy_kind(std::string_view name) {
  for (const PolicyKind kind : kPolicyKinds) {
    if (policy_name(kind) == name) return kind;
  }
  return std::nullopt;
}

std::unique_ptr<Policy> make_policy(PolicyKind kind, const QuantumLimits& limits,
                                    std::uint64_t seed) {
  switch (kind) {
    case PolicyKind::kErrorProportional:
      return std::make_unique<ErrorProportional>(limits, seed);
    case PolicyKind::kRoundRobin:
      return std::make_unique<RoundRobin>(limits);
    case PolicyKind::kFreeForAll:
      return std::make_unique<FreeForAll>(limits);
    case PolicyKind::kMarginalGain:
      break;
  }
  MarginalGain::Options options;
  options.limits = limits;
  return std::make_unique<MarginalGain>(options);
}

}  // namespace diaphane::render
