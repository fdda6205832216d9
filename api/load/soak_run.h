#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/load/viewer.h"
#include "api/service/placement.h"

namespace diaphane::api::load {

struct SoakOptions {
  ViewerOptions viewer;  ///< size and pauses are each visit's own
  std::size_t people = 50;
  double seconds = 60;
  double act_seconds = 4;
  double scale = 1;  ///< of the windows
  std::string data_set;
  unsigned threads = 2;
  std::uint64_t seed = 1;
};

/// People come, look, drag, hide, reload, are cut off and go, for so long. What happened, counted:
/// a picture that did not come within 30 s and a stream that ended by itself among it.
nlohmann::ordered_json soak_run(const SoakOptions& options, Placement& placement);

}  // namespace diaphane::api::load
