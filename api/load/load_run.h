#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/load/crowd.h"
#include "api/load/stage.h"
#include "common/result.h"

namespace diaphane::api::load {

/// The next number of sessions to try on the way to the most that hold a bound, in steps of a
/// doubling and then by halves, to within a sixteenth. Pure.
class Search {
 public:
  Search(std::size_t first, std::size_t most) : next_(first), most_(most) {}
  /// Nothing more to try when it is 0.
  std::size_t next() const { return next_; }
  void tried(bool held);
  std::size_t largest_held() const { return held_; }

 private:
  std::size_t next_, most_;
  std::size_t held_ = 0;
  std::size_t failed_ = 0;  // 0: none yet
};

struct LoadOptions {
  Stage::Options stage;
  CrowdOptions crowd;
  double bound_seconds = 0.1;  ///< of p95
  unsigned repeats = 1;        ///< of the run that is asked for
  bool find = false;           ///< also search the largest number of sessions that holds the bound
  std::size_t most_sessions = 1024;
};

/// JSON of all runs; a line of each is given to `tell` as it ends.
Result<nlohmann::ordered_json> load_run(LoadOptions options,
                                        const std::function<void(const std::string&)>& tell);

}  // namespace diaphane::api::load
