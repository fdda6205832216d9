#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Lets every session that gains render at once, regardless of the others. This is a baseline of
/// the thesis (5.1.1: "let each render node work as fast as it can"). The device alone decides the
/// order, so an input waits for as many quanta as there are sessions.
class FreeForAll final : public Policy {
 public:
  explicit FreeForAll(QuantumLimits limits = {}) : limits_(limits) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

 private:
  QuantumLimits limits_;
};

}  // namespace diaphane::render
