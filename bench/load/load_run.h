#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/load/crowd.h"
#include "bench/load/stage.h"
#include "common/result.h"

namespace diaphane::api::load {

/// Searches for the largest number of sessions that keeps a latency limit, by doubling and then
/// bisection, to within a sixteenth. Pure.
class Search {
 public:
  Search(std::size_t first, std::size_t most) : next_(first), most_(most) {}
  /// Returns the number of sessions to try next, or 0 when the search is finished.
  std::size_t next() const { return next_; }
  void tried(bool held);
  std::size_t largest_held() const { return held_; }

 private:
  std::size_t next_, most_;
  std::size_t held_ = 0;
  std::size_t failed_ = 0;  // 0: no failure yet
};

struct LoadOptions {
  Stage::Options stage;
  CrowdOptions crowd;
  double bound_seconds = 0.1;  ///< latency limit for the 95th percentile
  unsigned repeats = 1;        ///< number of runs with the requested number of sessions
  bool find = false;           ///< also search for the largest number of sessions within the limit
  std::size_t most_sessions = 1024;
};

/// Returns the JSON of all runs, and passes a line per run to `print` when it ends.
Result<nlohmann::ordered_json> load_run(LoadOptions options,
                                        const std::function<void(const std::string&)>& print);

}  // namespace diaphane::api::load
