#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace diaphane::kube {

/// The fields of a coordination.k8s.io Lease that leader election uses.
struct LeaseRecord {
  std::string holder;  ///< empty: released
  std::string version;
  std::chrono::seconds duration{15};
  int transitions = 0;
  std::string acquired;  ///< text as written, unchanged while the holder stays the same
  std::string renewed;
  bool operator==(const LeaseRecord&) const = default;
};

/// Leader election by a Lease. It never compares clocks of different machines: the holder counts as
/// lost when the record has not changed for its duration by the local clock. Pure.
class LeaseDecision {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Options {
    std::string identity;
    std::chrono::seconds duration{15};
    std::chrono::seconds renew_deadline{10};  ///< a leader that could not renew for this long exits
    std::chrono::seconds retry{2};
    double jitter = 1.2;  ///< factor for the retry interval of a follower
  };
  enum class Step {
    kWait,     ///< another process leads, or the renewal is not due
    kCreate,   ///< there is no lease yet
    kAcquire,  ///< write our identity into it, with the version that was read
    kRenew,
    kLost  ///< this process led and lost the lease, and exits
  };

  explicit LeaseDecision(Options options) : options_(std::move(options)) {}

  /// Records what was read. nullopt: the lease does not exist.
  void observed(const std::optional<LeaseRecord>& record, Time now);
  /// Records a successful write. The lease runs from `begun`, when the write started, and not from
  /// its answer.
  void written(const LeaseRecord& record, Time begun);

  Step step(Time now) const;
  /// Returns the time until the next step. `random` is in [0, 1).
  std::chrono::milliseconds pause(double random) const;
  bool leads(Time now) const { return leading_ && now - renewed_ < options_.renew_deadline; }
  bool has_led() const { return leading_; }
  const std::optional<LeaseRecord>& record() const { return record_; }

 private:
  Options options_;
  std::optional<LeaseRecord> record_;
  bool known_ = false;
  Time changed_{};
  bool leading_ = false;
  Time renewed_{};
};

}  // namespace diaphane::kube
