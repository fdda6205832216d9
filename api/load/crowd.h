#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "api/load/person.h"
#include "api/service/placement.h"
#include "common/result.h"

namespace diaphane::api::load {

struct CrowdOptions {
  ViewerOptions viewer;
  std::size_t sessions = 1;
  std::size_t moving = 1;        ///< at any moment
  double warm_up_seconds = 3;    ///< of movement, before it is measured
  double seconds = 10;           ///< measured
  double opening_seconds = 120;  ///< for all first pictures
  std::string data_set;
  std::string preset;
  unsigned threads = 2;
  std::uint64_t seed = 1;
};

struct CrowdResult {
  std::size_t opened = 0;     ///< sessions whose first picture came
  std::size_t refused = 0;    ///< not placed
  std::map<int, int> closed;  ///< streams that ended by themselves, by close code
  std::size_t problems = 0;
  std::vector<double> opening_seconds;
  double seconds = 0;  ///< that were measured
  Seen seen;           ///< of all together
};

/// Opens all sessions, lets `moving` of them drag at any moment, and measures. `measured` is called
/// with false at the beginning and with true at the end of what is measured. kUnavailable when
/// nobody sees a picture.
Result<CrowdResult> run_crowd(const CrowdOptions& options, Placement& placement,
                              const std::function<void(bool)>& measured);

}  // namespace diaphane::api::load
