#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "api/shared/placement.h"
#include "bench/load/person.h"
#include "common/result.h"

namespace diaphane::api::load {

struct CrowdOptions {
  ViewerOptions viewer;
  std::size_t sessions = 1;
  std::size_t moving = 1;        ///< sessions that move at any moment
  double warm_up_seconds = 3;    ///< seconds of movement before the measurement
  double seconds = 10;           ///< seconds of the measurement
  double opening_seconds = 120;  ///< time limit for all first pictures
  std::string data_set;
  std::string preset;
  std::shared_ptr<const Recording> recording;  ///< null: everyone turns around the scan
  unsigned threads = 2;
  std::uint64_t seed = 1;
};

struct CrowdResult {
  std::size_t opened = 0;     ///< sessions with a first picture
  std::size_t refused = 0;    ///< sessions that were not placed
  std::map<int, int> closed;  ///< streams that ended on their own, by close code
  std::size_t problems = 0;
  std::vector<double> opening_seconds;
  double seconds = 0;         ///< length of the measurement
  Measurements measurements;  ///< measurements of all sessions
};

/// Opens all sessions, lets `moving` of them drag at any moment, and measures. `measured` is called
/// with false at the start and with true at the end of the measurement. Fails with kUnavailable if
/// no session receives a picture.
Result<CrowdResult> run_crowd(const CrowdOptions& options, Placement& placement,
                              const std::function<void(bool)>& measured);

}  // namespace diaphane::api::load
