#pragma once

#include <cstdint>
#include <string>
#include <vector>

// Who is asked to help where a worker's sessions ask for more than its device has (docs/adr/0033).
// Pure: what is known of the neighbours goes in, the helpers come out.

namespace diaphane {

/// Another worker, as its last heartbeat told.
struct Neighbour {
  std::string id;
  double load = 0;  ///< what its own sessions took of its device in the last second; 1: all
  double lent = 0;  ///< what it did for other workers' sessions
  double age = 0;   ///< s, of the sample
  bool same_node = false;
  bool has_volume = false;  ///< one that is looked at here
  bool draining = false;
};

struct Helper {
  std::string id;
  double expected = 0;  ///< of its device, when it was asked
  double since = 0;     ///< s
};

/// Of one worker, from second to second.
struct Lending {
  std::vector<Helper> helpers;
  double calm = 0;  ///< s since its own device was enough
};

struct LendingRules {
  std::size_t most = 3;  ///< helpers of one worker
  /// Asked for: from here on it borrows; below `enough` for `rest` seconds it gives all back.
  double borrows = 1.05, enough = 0.85, rest = 3;
  /// Of a neighbour's device: with so much in use it is not asked; it is given back where its own
  /// sessions take so much.
  double idle = 0.7, busy = 0.9;
  double oldest = 3;  ///< s, of a sample that counts: as long as a heartbeat lives
  /// A helper that was asked so lately may still be loading the volume: what is expected of it
  /// counts as if it came.
  double settles = 3;
};

struct LendingQuestion {
  double seconds = 1;  ///< since the last
  double asked = 0;    ///< of its device by its own sessions at this moment; 1: all there is
  double helped = 0;   ///< what came from helpers in the last second, in devices
  /// Some at random, and the helpers that it has: who is not among them has gone.
  std::vector<Neighbour> neighbours;
};

/// The helpers from now on: those before, less who is busy, drains or has gone, and new ones where
/// more is asked for than there is. New ones are each the better of two at random, so that a crowd
/// does not ask the same one.
Lending lend(Lending before, const LendingQuestion& question, const LendingRules& rules,
             std::uint64_t seed);

}  // namespace diaphane
