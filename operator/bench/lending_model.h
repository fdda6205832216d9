#pragma once

#include <vector>

#include "common/lending.h"
#include "operator/plan/random.h"

namespace diaphane::fleet::bench {

struct LendingCosts {
  /// Of what a helper does, that goes into handing parts over: the most that `part_due` allows.
  double handing = 0.125;
  /// Of the one who is helped, to merge what a helper's whole device brings. No more was measured
  /// by way of the host's memory than that it may be as long as rendering (docs/figures.md,
  /// `many`).
  double merging = 0.125;
  /// Until a helper has the volume; nobody has it before he is asked.
  double load_seconds = 1;
};

/// What devices do for each other's sessions, in steps of a second: each decides by
/// common/lending.h, from what its neighbours said a second ago.
class LendingModel {
 public:
  struct Device {
    bool there = false;  ///< alive, and takes part
    bool draining = false;
    double wants = 0;  ///< asked for by its own sessions
  };

  LendingModel(LendingRules rules, LendingCosts costs, std::uint64_t seed)
      : rules_(rules), costs_(costs), random_(seed) {}

  void step(const std::vector<Device>& devices);
  /// What is asked of a device after that: by its sessions, less what others do for them, and by
  /// its neighbours' sessions. What helping costs is in it.
  double load(std::size_t device) const { return loads_[device]; }
  double lent() const { return lent_; }  ///< by all, devices
  std::size_t helpers() const { return helpers_; }
  std::size_t begun() const { return begun_; }  ///< helpers that were asked in this step

 private:
  struct Said {
    double load = 0, lent = 0;
  };

  void decide(const std::vector<Device>& devices);
  void share_out(const std::vector<Device>& devices);
  Neighbour seen(const Device& device, std::size_t number) const;

  const LendingRules rules_;
  const LendingCosts costs_;
  Random random_;
  std::vector<Lending> lendings_;
  std::vector<Said> said_;
  std::vector<double> helped_;  ///< in the step before
  std::vector<double> loads_;
  double lent_ = 0;
  std::size_t helpers_ = 0, begun_ = 0;
};

}  // namespace diaphane::fleet::bench
