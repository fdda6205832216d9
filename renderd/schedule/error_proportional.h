#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// The policy of the thesis (5.1.1). It draws one session with a probability proportional to its
/// expected error 1 / sqrt(n) after n iterations. Each input resets n, and a session without an
/// iteration counts as one that has had its first.
///
/// The draw is a race: each session gets an exponentially distributed time of rate 1 / sqrt(n), and
/// the smallest time wins. Its random number depends on the seed, the number of the draw and the
/// handle of the session, so the order of the views does not matter.
class ErrorProportional final : public Policy {
 public:
  explicit ErrorProportional(QuantumLimits limits = {}, std::uint64_t seed = 1)
      : limits_(limits), seed_(seed) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

 private:
  QuantumLimits limits_;
  std::uint64_t seed_;
  std::uint64_t draws_ = 0;
};

}  // namespace diaphane::render
