#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Limits the device time of visitors and guests (people without an account) together. While a
/// picture of an account holder gains, they get at most `share` of the time that quanta are
/// expected to take. Within that limit, and whenever no picture of an account holder gains, `inner`
/// decides among all sessions. This is a credit scheme, like a token bucket that the quanta of
/// account holders refill. Unlike other policies, next() returns nothing although a visitor waits
/// if visitors have used up their share and the quanta of all account holders are in flight.
class VisitorShare final : public Policy {
 public:
  VisitorShare(std::unique_ptr<Policy> inner, double share)
      : inner_(std::move(inner)), share_(share) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;
  std::vector<Quantum> overtaking(std::span<const SessionView> sessions, unsigned highest) override;

  /// Returns the seconds by which visitors are behind their share (positive) or ahead of it
  /// (negative). They wait while it is negative.
  double credit() const { return credit_; }

 private:
  using Choice = std::function<std::vector<Quantum>(std::span<const SessionView>)>;
  std::vector<Quantum> shared(std::span<const SessionView> sessions, const Choice& choice);

  std::unique_ptr<Policy> inner_;
  const double share_;
  double credit_ = 0;
};

}  // namespace diaphane::render
