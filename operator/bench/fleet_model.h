#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/expected_share.h"
#include "operator/bench/lending_model.h"
#include "operator/plan/plan.h"
#include "operator/plan/random.h"

// A fleet of thousands of devices in steps of a second: the plan places its workers, one of three
// ways its sessions, and with the first of them what devices have left may be lent. The model: a
// session stays for an exponential time, and looks (wanting a share of its device that is its own,
// log-normal) and rests by turns. What it wants of a device that is asked for more than there is
// comes late: that is lost to imbalance, as far as others idle.

namespace diaphane::fleet::bench {

enum class Way {
  kLoad,  ///< as place.lua: of 64 at random the one whose sessions are expected to take least
  kLoadAndLending,  ///< so too, and who is asked for more than there is asks neighbours to help
  kRoundRobin,      ///< by turns, full ones passed over
  kLeastCount       ///< fewest sessions
};
const char* name_of(Way way);

struct Setting {
  int sessions = 100'000;
  int devices = 8'000;  ///< eight a node
  int slots = 16;
  int ramp_seconds = 120;  ///< from none to all sessions
  int seconds = 300;       ///< thereafter, measured
  double stay_seconds = 1200;
  double looking_seconds = 10, resting_seconds = 20;
  double wanted = 0.7;                  ///< of all devices, by all sessions together
  double spread = 1;                    ///< of the logarithm of a session's share
  double crashes_per_second = 0.2;      ///< pods
  double nodes_lost_per_second = 0.02;  ///< come back after a minute
  double cordons_per_second = 0.02;     ///< for two minutes
  std::uint64_t seed = 1;
  LendingRules lending;
  LendingCosts lending_costs;
};

struct Figures {
  double lost = 0;  ///< of what sessions wanted, while other devices idled
  /// Of what devices were asked for, what they do for each other included: standard deviation over
  /// mean. By node: of the means of eight.
  double spread = 0, spread_by_node = 0;
  double spread_of_busy = 0;  ///< the same where more than a device has counts as all of it
  /// The same of what their sessions ask for on the whole, looking and resting: what a placing can
  /// even out that moves nobody.
  double spread_of_stays = 0, spread_of_stays_by_node = 0;
  double lent = 0;     ///< of all devices' time, what helping costs included
  double helpers = 0;  ///< at a moment, of each device
  double begun = 0;    ///< helpers that a device asks, a minute
  double refused = 0;  ///< of placings
  long placings = 0;
  long moves = 0;                    ///< sessions placed again because theirs was lost or drained
  long moved_alive = 0;              ///< of these, by a drain
  long over_committed = 0;           ///< seconds of nodes with more workers than GPUs
  std::vector<double> plan_seconds;  ///< of each reconcile
};

class FleetModel {
 public:
  FleetModel(const Setting& setting, Way way);
  Figures run();
  const World& world() const { return world_; }

 private:
  struct Session {
    int device = -1;  ///< of devices_
    double share = 0;
    ExpectedShare expected;
    bool looks = true;
    Seconds turns = 0, ends = 0;
  };
  /// One for each ordinal a worker's name has had.
  struct Device {
    std::string name;
    bool ready = false, told = false;
    Seconds ready_at = 0;
    int sessions = 0;
    double wants = 0;
    double shares = 0;  ///< of its sessions, were all to look at once
    int given = 0;      ///< since the last sample
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
  World world_;
  Random random_;
  Random faults_;  ///< the same whatever the way
  std::mt19937_64 normal_;
  std::vector<Session> sessions_;
  std::vector<Device> devices_;
  std::unordered_map<std::string, int> numbers_;
  std::unordered_map<std::string, int> node_numbers_;
  std::unordered_map<std::string, std::size_t> workers_, pods_;  ///< by name, into world_
  std::map<std::string, Seconds> back_;                          ///< nodes
  std::vector<std::size_t> waiting_;                             ///< sessions without a device
  std::size_t turn_ = 0;
  std::uint64_t counter_ = 0;
  LendingModel lending_;
};

}  // namespace diaphane::fleet::bench
