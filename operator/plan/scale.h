#pragma once

#include <vector>

#include "operator/plan/world.h"

// How many workers a fleet has, and how fast it gets them.

namespace diaphane::fleet {

/// From `least` on none is added, up to `most` none is taken away.
struct Wanted {
  int least = 0;
  int most = 0;
};

/// `usable`: workers that take sessions or will soon. Without fresh demand it stays at these.
Wanted wanted_workers(const FleetSpec& spec, const Demand* demand, int usable, Seconds now);

/// A token bucket that holds a second's worth, at least one, whose history is the workers' own
/// times of creation: nothing to remember, and the same for whoever leads.
struct Tokens {
  double count = 0;
  Seconds next = 0;  ///< when there is a whole one
};
Tokens refill_tokens(double per_second, std::vector<Seconds> created, Seconds now);

}  // namespace diaphane::fleet
