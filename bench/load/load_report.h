#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/load/crowd.h"
#include "bench/load/stage.h"

namespace diaphane::api::load {

/// Reports one run: latency from input to frame and its parts, data sent, and CPU usage. `before`
/// and `after` enclose the measurement.
nlohmann::ordered_json load_report(const CrowdOptions& options, CrowdResult result,
                                   const Usage& before, const Usage& after);
/// Returns the same report as one line of text under load_heading().
std::string load_line(const nlohmann::ordered_json& report);
std::string load_heading();

}  // namespace diaphane::api::load
