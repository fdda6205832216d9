#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Every session that gains renders at once, without notice of the others; a baseline of the thesis
/// (5.1.1: "let each render node work as fast as it can"). What the device makes of it is its own
/// affair: an input waits for as many quanta as there are sessions.
class FreeForAll final : public Policy {
 public:
  explicit FreeForAll(QuantumLimits limits = {}) : limits_(limits) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

 private:
  QuantumLimits limits_;
};

}  // namespace diaphane::render
