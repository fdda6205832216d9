#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderd/schedule/policy.h"

namespace diaphane::render::bench {

/// One column of the thesis's Figure 9: a sequence of nodes whose iterations were computed.
struct Situation {
  std::string what;
  std::vector<std::uint64_t> iterations;  ///< per node, at the start of the snapshot
  struct Turn {
    std::size_t node = 0;         ///< from 1
    std::uint64_t iteration = 0;  ///< number of the computed iteration
  };
  std::vector<Turn> turns;       ///< fifteen, as in the figure
  std::vector<double> shares;    ///< each node's share of the turns over many such snapshots
  std::vector<double> expected;  ///< proportional to 1 / sqrt(n) at the start of the snapshot
};

/// Simulates the seven situations of Figure 9, with the iterations read from it, with the thesis's
/// policy and quanta of one iteration.
std::vector<Situation> figure9(std::uint64_t seed);
std::string figure9_text(const std::vector<Situation>& situations);
std::string figure9_json(const std::vector<Situation>& situations);

}  // namespace diaphane::render::bench
