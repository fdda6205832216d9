#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "bench/schedule/device_model.h"
#include "bench/schedule/scores.h"
#include "bench/schedule/trace.h"
#include "renderd/schedule/in_flight.h"
#include "renderd/schedule/policy.h"

namespace diaphane::render::bench {

/// Simulates a device with the runner's policy, ledger, and rules for canvases, emission and room,
/// on a clock that advances from event to event. A session's error is noise / sqrt(n), and costs
/// come from the model. Concurrent quanta share the device in proportion to their fill, and host
/// work for one runs in parallel to the others. Events must arrive in order of time.
class SimulatedDevice {
 public:
  SimulatedDevice(const DeviceModel& model, std::unique_ptr<Policy> policy, LedgerRules rules);
  ~SimulatedDevice();

  /// Handles an event of one of its sessions. `session` is the index in the trace.
  void happen(const TraceEvent& event, const TraceSession& session, SessionScore& score);
  /// Renders until `seconds`. Work in progress continues in the next call.
  void run_until(double seconds);

  const DeviceTime& time() const { return time_; }
  /// Returns the load: the summed errors of its sessions' pictures, as the scheduler measures it.
  /// Converged and hidden sessions count 0.
  double summed_error() const;
  std::size_t sessions() const { return sessions_.size(); }

 private:
  struct Session;
  struct Turn;
  using SessionPtr = std::shared_ptr<Session>;

  void deliver();
  void input(Session& session, const TraceEvent& event);
  void fill();
  void begin(const SessionPtr& session, std::uint32_t samples);
  void begin_picture(Turn& turn);
  bool due(Session& session) const;
  void advance(double until);
  void pass(double seconds, double rate);
  void next_phase(Turn& turn);
  void rendered(Turn& turn);
  double next_event() const;
  double next_rest() const;
  Ledger::Time time_point(double seconds) const;

  DeviceModel model_;
  std::unique_ptr<Policy> policy_;
  LedgerRules rules_;
  DeviceCosts costs_;
  double now_ = 0;
  std::vector<SessionPtr> sessions_;
  std::vector<Turn> turns_;
  InFlight in_flight_;
  struct Coming {
    TraceEvent event;
    const TraceSession* session;
    SessionScore* score;
  };
  std::deque<Coming> coming_;
  DeviceTime time_;
};

}  // namespace diaphane::render::bench
