#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "renderd/bench/schedule/device_model.h"
#include "renderd/bench/schedule/scores.h"
#include "renderd/bench/schedule/trace.h"
#include "renderd/schedule/policy.h"

namespace diaphane::render::bench {

/// A device without a device: the same policy, ledger, canvas and emission rules as the runner's,
/// on a clock that only moves when something is rendered. A session's error is noise / sqrt(n);
/// what things cost is the model's. Events come in order of time.
class SimulatedDevice {
 public:
  SimulatedDevice(const DeviceModel& model, std::unique_ptr<Policy> policy, LedgerRules rules);
  ~SimulatedDevice();

  /// What happens to one of its sessions; `session` is the index in the trace.
  void happen(const TraceEvent& event, const TraceSession& session, SessionScore& score);
  /// Renders until `seconds`; what is under way then is finished.
  void run_until(double seconds);

  const DeviceTime& time() const { return time_; }
  /// How busy it is: the errors that its sessions' pictures still have, the scheduler's own
  /// measure; one that is converged or hidden counts nothing.
  double summed_error() const;
  std::size_t sessions() const { return sessions_.size(); }

 private:
  struct Session;
  struct Turn;

  void deliver();
  void emit(Session& session);
  bool step();
  void carry_out(const std::vector<Quantum>& round);
  double next_event() const;
  Ledger::Time time_point(double seconds) const;

  DeviceModel model_;
  std::unique_ptr<Policy> policy_;
  LedgerRules rules_;
  DeviceCosts costs_;
  double now_ = 0;
  std::vector<std::unique_ptr<Session>> sessions_;
  struct Coming {
    TraceEvent event;
    const TraceSession* session;
    SessionScore* score;
  };
  std::deque<Coming> coming_;
  DeviceTime time_;
};

}  // namespace diaphane::render::bench
