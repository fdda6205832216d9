#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "directory/constants.h"

// Chooses the peers that assist a worker whose sessions need more than its device has
// (docs/adr/0033). The functions are pure: they map the known state of the peers to the helpers.

namespace diaphane::directory {

/// Another worker, as of its last heartbeat.
struct PeerLoad {
  std::string id;
  double load = 0;  ///< share of its device used by its own sessions in the last second, 0 to 1
  double lent = 0;  ///< share used for other workers' sessions
  double age = 0;   ///< age of the sample in seconds
  bool same_node = false;
  bool has_volume = false;  ///< has loaded a volume that is viewed on this worker
  bool draining = false;
};

struct Helper {
  std::string id;
  double expected = 0;  ///< expected share of its device when it was asked
  double since = 0;     ///< seconds since it was asked
  /// Whether it helps only with time that nothing else needs. It yields to its own sessions and to
  /// workers that need its help.
  bool spare = false;
};

/// State of one worker between two calls, one second apart.
struct Lending {
  std::vector<Helper> helpers;
  double calm = 0;   ///< for how many seconds its own device has been sufficient
  double still = 0;  ///< for how many seconds its own sessions have rendered nothing
};

struct LendingRules {
  std::size_t most = 3;  ///< maximum number of helpers
  /// Maximum number of helpers while its device is sufficient. They make a picture finish sooner
  /// with time that nobody else needs.
  std::size_t most_spare = 0;
  /// A worker borrows if its demand exceeds `borrows`. Once the demand has been below `enough` for
  /// `rest` seconds, it releases all helpers.
  double borrows = 1.05, enough = 0.85, rest = 3;
  /// Load limits of a peer's device, from 0 to 1. A peer above `idle` in total is not asked, and a
  /// helper is released if its own sessions reach `busy`.
  double idle = 0.7, busy = 0.9;
  /// The same for spare time. A helper with spare time costs little while it waits, and loading the
  /// volume takes longer than most pictures, so it is kept for `lingers` seconds after the last
  /// picture.
  double spare_idle = 0.3, spare_busy = 0.5, lingers = 30;
  /// A device whose own sessions ask for less renders nothing that anyone waits for.
  double renders = 0.02;
  double oldest = kHeartbeatMs / 1000.0;  ///< maximum age of a sample in seconds
  /// A helper that was asked less than this long ago may still be loading the volume. Until then,
  /// its expected share counts as delivered.
  double settles = 3;
};

struct LendingInput {
  double seconds = 1;  ///< seconds since the last call
  double asked = 0;    ///< current demand of its own sessions, in devices
  double helped = 0;   ///< work of the helpers in the last second, in devices
  /// A random sample of peers plus the current helpers. A helper that is not in it is gone.
  std::vector<PeerLoad> peers;
};

/// Returns the new set of helpers: the previous ones without those that are busy, draining or gone,
/// plus new ones if the demand exceeds the supply. Each new helper is the better of two random
/// peers, so that many workers do not ask the same one. Helpers with spare time are the first to be
/// asked for more. While the sessions render, idle peers are asked for their spare time.
Lending lend(Lending before, const LendingInput& input, const LendingRules& rules,
             std::uint64_t seed);

}  // namespace diaphane::directory
