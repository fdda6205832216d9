#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Gives every session that gains one quantum in turn, in the order of the handles. This is a
/// baseline of the thesis (5.1.1: "every render node starts when the previous one finishes").
class RoundRobin final : public Policy {
 public:
  explicit RoundRobin(QuantumLimits limits = {}) : limits_(limits) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

 private:
  QuantumLimits limits_;
  std::uint64_t last_ = 0;  // handle of the session that had the last quantum
};

}  // namespace diaphane::render
