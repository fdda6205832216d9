#pragma once

#include <vector>

#include "operator/plan/cluster_state.h"

// Computes how many workers a fleet needs, and how fast they are created.

namespace diaphane::fleet {

/// Below `least`, workers are added. Above `most`, workers are removed.
struct DesiredReplicas {
  int least = 0;
  int most = 0;
};

/// Returns the desired number of workers. `usable` is the number of workers that accept sessions or
/// soon will, which is kept if there is no fresh demand.
DesiredReplicas desired_replicas(const FleetSpec& spec, const Demand* demand, int usable,
                                 Seconds now);

/// A token bucket with a capacity of one second, at least one token. Its state follows from the
/// creation times of the workers, so there is nothing to store, and every leader computes the same.
struct Tokens {
  double count = 0;  ///< available tokens
  Seconds next = 0;  ///< time at which the next whole token is available
};
Tokens refill_tokens(double per_second, std::vector<Seconds> created, Seconds now);

}  // namespace diaphane::fleet
