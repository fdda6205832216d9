#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// The thesis's own (5.1.1): one session is drawn, with a probability proportional to its expected
/// error 1 / sqrt(n) after n iterations; n begins anew with each input. A session without an
/// iteration counts as one with its first.
///
/// The draw is a race: each session's time is exponential with the rate 1 / sqrt(n), the first
/// wins. Its random number comes of the seed, the number of the draw and its handle, so that the
/// order of the views is of no meaning.
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
