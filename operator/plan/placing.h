#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "operator/plan/random.h"
#include "operator/plan/view.h"

// Chooses nodes for the workers of a fleet.

namespace diaphane::fleet {

struct Candidate {
  double load = 0;  ///< 1: full
  int free = 0;     ///< number of further workers or sessions for which there is room
};

/// A difference in load up to this is ignored.
inline constexpr double kHysteresis = 0.1;

/// Chooses among the candidates with room. Least loaded: draws two at random from those within the
/// hysteresis of the lowest load and takes the better one, so that concurrent decisions from the
/// same loads differ (Mitzenmacher 2001). Packed: takes the one with the least room.
std::optional<std::size_t> choose(std::span<const Candidate> candidates, Strategy strategy,
                                  Random& random);

/// Why a node cannot run a worker of the fleet, regardless of its load. nullopt: it can.
enum class Unfit { kNotReady, kCordoned, kSelector, kTaint, kSilent, kRefused, kTooSmall, kFull };
std::optional<Unfit> unfit(const NodeView& node, const FleetSpec& spec,
                           const std::vector<NodeBackoff>& refusals, Seconds now);

/// Chooses nodes one after the other and reserves the GPUs of one worker on each.
class Placing {
 public:
  Placing(const Fleet& fleet, const std::vector<NodeBackoff>& refusals,
          std::vector<NodeView>& nodes, Seconds now);
  /// Returns the name of a node, or nullptr if none has room.
  const std::string* next(Strategy strategy, Random& random);
  bool room() const;
  /// Explains the result: "0 of 12 nodes have room: 3 cordoned, 9 full".
  std::string why() const;
  /// Returns when the next refused node may be tried again.
  std::optional<Seconds> again() const { return again_; }

 private:
  std::vector<NodeView>& nodes_;
  int gpus_;                      ///< per worker
  std::vector<std::size_t> fit_;  ///< index in nodes_ per candidate
  std::vector<Candidate> candidates_;
  std::vector<int> unfit_;  ///< number of nodes per reason
  std::optional<Seconds> again_;
};

}  // namespace diaphane::fleet
