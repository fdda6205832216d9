#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "bench/operator/lending_model.h"
#include "common/expected_share.h"
#include "operator/plan/plan.h"
#include "operator/plan/random.h"

// A simulated fleet of thousands of devices in steps of one second. The plan places its workers,
// and one of the placement policies places its sessions. One of them also lends unused device time.
// A session stays for an exponential time and alternates between looking and resting. While it
// looks, it wants a share of its device, drawn from a log-normal distribution. Work that an
// overloaded device cannot do in time counts as lost to imbalance as far as other devices are idle.

namespace diaphane::fleet::bench {

enum class Way {
  kLoad,  ///< the device with the smallest expected load of 64 random ones, as in place.lua
  kLoadAndLending,  ///< kLoad, and overloaded devices borrow from peers
  kRoundRobin,      ///< the next device in turn that is not full
  kLeastCount       ///< fewest sessions
};
const char* name_of(Way way);

struct Setting {
  int sessions = 100'000;
  int devices = 8'000;  ///< eight per node
  int slots = 16;
  int ramp_seconds = 120;  ///< time from no session to all of them
  int seconds = 300;       ///< measured time after the ramp
  double stay_seconds = 1200;
  double looking_seconds = 10, resting_seconds = 20;
  double wanted = 0.7;              ///< share of all devices that all sessions together want
  double spread = 1;                ///< standard deviation of the logarithm of a session's share
  double crashes_per_second = 0.2;  ///< crashed pods per second
  double nodes_lost_per_second = 0.02;  ///< lost nodes return after one minute
  double cordons_per_second = 0.02;     ///< cordoned nodes per second, for two minutes each
  std::uint64_t seed = 1;
  LendingRules lending;
  LendingCosts lending_costs;
};

struct Figures {
  double lost = 0;  ///< share of the demand that was not served while other devices were idle
  /// Demand on devices, including work for each other: standard deviation divided by mean.
  /// spread_by_node uses the mean of the eight devices of each node.
  double spread = 0, spread_by_node = 0;
  double spread_of_busy = 0;  ///< `spread` with overload counted as full load
  /// Spread of the sum of the shares of a device's sessions, whether they look or rest. Placement
  /// without migration can only even out this part.
  double spread_of_stays = 0, spread_of_stays_by_node = 0;
  double lent = 0;     ///< share of all devices' time, including the cost of lending
  double helpers = 0;  ///< average number of helpers per device
  double begun = 0;    ///< helpers that a device engages per minute
  double refused = 0;  ///< share of placements
  long placings = 0;
  long moves = 0;           ///< sessions placed again because their worker was lost or drained
  long moved_alive = 0;     ///< number of `moves` because of a drain
  long over_committed = 0;  ///< seconds in which a node had more workers than GPUs
  std::vector<double> plan_seconds;  ///< per reconcile
};

class FleetModel {
 public:
  FleetModel(const Setting& setting, Way way);
  Figures run();
  const ClusterState& world() const { return world_; }

 private:
  struct Session {
    int device = -1;  ///< index in devices_
    double share = 0;
    ExpectedShare expected;
    bool looks = true;
    Seconds turns = 0, ends = 0;
  };
  /// A device with the state of its worker. There is one per ordinal in the workers' names.
  struct Device {
    std::string name;
    bool ready = false, draining = false;
    Seconds ready_at = 0;
    int sessions = 0;
    double wants = 0;
    double shares = 0;  ///< sum of the shares of its sessions, as if all looked at once
    int given = 0;      ///< sessions placed since the last sample
    double expected = 0;
    Seconds idle_since = 0;
    int node = 0;
  };

  void reconcile(Figures& figures, bool measured);
  void apply(const Action& action);
  void trouble();
  void run_pods();
  void run_sessions(Figures& figures, bool measured, int target);
  void take_samples();
  void lend_devices();
  double load(std::size_t device) const;
  void measure(Figures& figures) const;
  int place(int but = -1);
  void put(Session& session, int device);
  void take_out(Session& session);
  bool open(int device) const;
  double score(int device) const;
  Worker* worker(const std::string& name);
  Pod* pod(const std::string& name);
  int device_of(const std::string& name);
  void remove_worker(const std::string& uid);
  void remove_pod(const std::string& uid);
  void strand(int device);
  double unit() { return random_.unit(); }
  double exponential(double mean);

  Setting setting_;
  Way way_;
  ClusterState world_;
  Random random_;
  Random faults_;  ///< draws of faults, the same for every policy
  std::mt19937_64 normal_;
  std::vector<Session> sessions_;
  std::vector<Device> devices_;
  std::unordered_map<std::string, int> numbers_;
  std::unordered_map<std::string, int> node_numbers_;
  std::unordered_map<std::string, std::size_t> workers_, pods_;  ///< index in world_ by name
  std::map<std::string, Seconds> back_;                          ///< by node
  std::vector<std::size_t> waiting_;                             ///< sessions without a device
  std::size_t turn_ = 0;
  std::uint64_t counter_ = 0;
  LendingModel lending_;
};

}  // namespace diaphane::fleet::bench
