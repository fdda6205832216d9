#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/shared/placement.h"
#include "bench/load/viewer.h"

namespace diaphane::api::load {

struct SoakOptions {
  ViewerOptions viewer;  ///< size and pauses are set per visit
  std::size_t people = 50;
  double seconds = 60;
  double act_seconds = 4;
  double scale = 1;  ///< factor for the sides of the viewports
  std::string data_set;
  unsigned threads = 2;
  std::uint64_t seed = 1;
};

/// Runs users who come, look, drag, hide, reload, lose their connections and leave. Returns counts,
/// including pictures that did not arrive within 30 s and streams that ended on their own.
nlohmann::ordered_json soak_run(const SoakOptions& options, Placement& placement);

}  // namespace diaphane::api::load
