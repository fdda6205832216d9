#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace diaphane::kube {

/// A coordination.k8s.io Lease as far as leading needs it.
struct LeaseRecord {
  std::string holder;  ///< empty: given back
  std::string version;
  std::chrono::seconds duration{15};
  int transitions = 0;
  std::string acquired;  ///< as it was written: kept while the holder is the same
  std::string renewed;
  bool operator==(const LeaseRecord&) const = default;
};

/// Who leads, decided by a Lease. Clocks of different machines are never compared: a holder is
/// taken for lost when the record has not changed for its duration by our own clock. Pure.
class LeaseDecision {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Options {
    std::string identity;
    std::chrono::seconds duration{15};
    std::chrono::seconds renew_deadline{10};  ///< a leader that could not renew for so long, exits
    std::chrono::seconds retry{2};
    double jitter = 1.2;  ///< of a retry, by who does not lead
  };
  enum class Step {
    kWait,     ///< somebody else leads, or renewing is not due
    kCreate,   ///< there is no lease yet
    kAcquire,  ///< write ourselves into it, with the version that was read
    kRenew,
    kLost  ///< whoever led does no more, and exits
  };

  explicit LeaseDecision(Options options) : options_(std::move(options)) {}

  /// What was read (nothing: it is not there).
  void observed(const std::optional<LeaseRecord>& record, Time now);
  /// A write of ours that had begun at `begun` was taken. The lease runs from then, not from the
  /// answer.
  void written(const LeaseRecord& record, Time begun);

  Step step(Time now) const;
  /// How long until the next look; `random` in [0, 1).
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
