#pragma once

#include <vector>

#include "directory/lending.h"
#include "operator/plan/random.h"

namespace diaphane::fleet::bench {

using directory::Helper;
using directory::Lending;
using directory::LendingInput;
using directory::LendingRules;
using directory::PeerLoad;

struct LendingCosts {
  /// Share of a helper's work spent on transferring results: the maximum that `part_due` allows.
  double handing = 0.125;
  /// Share of the helped device's time for merging the output of a helper's whole device. It is an
  /// upper bound: measurements through host memory show only that merging may take up to as long as
  /// rendering (docs/figures.md, `many`).
  double merging = 0.125;
  /// Time until a helper has loaded the volume, which it does not have before it is asked.
  double load_seconds = 1;
};

/// Simulates what devices render for each other's sessions, in steps of one second. Each device
/// decides with directory/lending.h from the loads that its peers reported one second ago.
class LendingModel {
 public:
  struct Device {
    bool there = false;  ///< running and not draining
    bool draining = false;
    double wants = 0;  ///< demand of its own sessions
  };

  LendingModel(LendingRules rules, LendingCosts costs, std::uint64_t seed)
      : rules_(rules), costs_(costs), random_(seed) {}

  void step(const std::vector<Device>& devices);
  /// Returns the load of a device after lending: its own sessions, less what others render for
  /// them, plus its peers' sessions and the cost of helping.
  double load(std::size_t device) const { return loads_[device]; }
  /// Returns the shares of its helpers' devices that a device gets because nothing else needs them.
  const std::vector<double>& spare(std::size_t device) const { return spare_[device]; }
  double lent() const { return lent_; }  ///< sum over all devices, as a number of devices
  std::size_t helpers() const { return helpers_; }
  std::size_t begun() const { return begun_; }  ///< helpers engaged in this step

 private:
  struct Said {
    double load = 0, lent = 0;
  };

  void decide(const std::vector<Device>& devices);
  void share_out(const std::vector<Device>& devices);
  void share_out_spare(const std::vector<Device>& devices, const std::vector<double>& left);
  PeerLoad observed(const Device& device, std::size_t number) const;

  const LendingRules rules_;
  const LendingCosts costs_;
  Random random_;
  std::vector<Lending> lendings_;
  std::vector<Said> said_;
  std::vector<double> helped_;  ///< work that helpers did in the previous step
  std::vector<double> loads_;
  std::vector<std::vector<double>> spare_;
  double lent_ = 0;
  std::size_t helpers_ = 0, begun_ = 0;
};

}  // namespace diaphane::fleet::bench
