#pragma once

#include <memory>
#include <utility>

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Bounds what visitors and guests (people without an account) take of the device together: while
/// a picture of an account holder gains, at most `share` of the time that quanta are expected to
/// take. Within that bound, and whenever no account holder's picture gains, `inner` decides among
/// all. A credit scheme, as a token bucket whose tokens are earned by the others' quanta.
/// It gives no quantum although a visitor waits when visitors have used up their share and the
/// account holders' quanta are all under way.
class VisitorShare final : public Policy {
 public:
  VisitorShare(std::unique_ptr<Policy> inner, double share)
      : inner_(std::move(inner)), share_(share) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

  /// Seconds of the device that visitors may take beyond what account holders take now; negative:
  /// they wait for so much.
  double credit() const { return credit_; }

 private:
  std::unique_ptr<Policy> inner_;
  const double share_;
  double credit_ = 0;
};

}  // namespace diaphane::render
