#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "operator/plan/random.h"
#include "operator/plan/view.h"

// Which node takes a worker, which worker a session: the same question.

namespace diaphane::fleet {

struct Candidate {
  double load = 0;  ///< 1: full
  int free = 0;     ///< places
};

/// So much more load makes no difference.
inline constexpr double kHysteresis = 0.1;

/// Of those with a place. Least loaded: two at random of those that differ from the least loaded by
/// no more than the hysteresis, the better of the two: whoever decides at the same moment, by the
/// same loads, decides otherwise (Mitzenmacher 2001). Packed: the one with fewest places left.
std::optional<std::size_t> choose(std::span<const Candidate> candidates, Strategy strategy,
                                  Random& random);

/// Why a node cannot take a worker of the fleet, whatever its load; nothing: it can.
enum class Unfit { kNotReady, kCordoned, kSelector, kTaint, kSilent, kRefused, kFull };
std::optional<Unfit> unfit(const NodeView& node, const FleetSpec& spec,
                           const std::vector<Refusal>& refusals, Seconds now);

/// Chooses nodes one after the other, and takes a GPU of each.
class Placing {
 public:
  Placing(const Fleet& fleet, const std::vector<Refusal>& refusals, std::vector<NodeView>& nodes,
          Seconds now);
  /// The name of a node, or nothing where none has room.
  const std::string* next(Strategy strategy, Random& random);
  bool room() const;
  /// "0 of 12 nodes: 3 cordoned, 9 full".
  std::string why() const;
  /// When the first of the nodes that were refused is asked again.
  std::optional<Seconds> again() const { return again_; }

 private:
  std::vector<NodeView>& nodes_;
  std::vector<std::size_t> fit_;  ///< of nodes_, one for each candidate
  std::vector<Candidate> candidates_;
  std::vector<int> unfit_;  ///< nodes for each reason
  std::optional<Seconds> again_;
};

}  // namespace diaphane::fleet
