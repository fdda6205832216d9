#include "operator/kube/lease.h"

namespace diaphane::kube {

void LeaseDecision::observed(const std::optional<LeaseRecord>& record, Time now) {
  if (!known_ || record != record_) changed_ = now;
  known_ = true;
  record_ = record;
}

void LeaseDecision::written(const LeaseRecord& record, Time begun) {
  known_ = true;
  record_ = record;
  changed_ = begun;
  leading_ = true;
  renewed_ = begun;
}

LeaseDecision::Step LeaseDecision::step(Time now) const {
  const bool ours = record_ && record_->holder == options_.identity;
  if (leading_) {
    if (now - renewed_ >= options_.renew_deadline) return Step::kLost;
    // The lease was deleted, or another process took it while this one was suspended.
    return ours ? Step::kRenew : Step::kLost;
  }
  if (!known_) return Step::kWait;
  if (!record_) return Step::kCreate;
  // A lease that this identity held before a restart can be taken immediately.
  if (record_->holder.empty() || ours) return Step::kAcquire;
  return now - changed_ >= record_->duration ? Step::kAcquire : Step::kWait;
}

std::chrono::milliseconds LeaseDecision::pause(double random) const {
  const auto retry = std::chrono::duration_cast<std::chrono::milliseconds>(options_.retry);
  if (leading_) return retry;
  return std::chrono::milliseconds(static_cast<std::int64_t>(static_cast<double>(retry.count()) *
                                                             (1 + random * options_.jitter)));
}

}  // namespace diaphane::kube
