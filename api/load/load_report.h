#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/load/crowd.h"
#include "api/load/stage.h"

namespace diaphane::api::load {

/// One run in numbers: from input to frame, where the time goes, what was sent, who computed.
/// `before` and `after` enclose what was measured.
nlohmann::ordered_json load_report(const CrowdOptions& options, CrowdResult result,
                                   const Usage& before, const Usage& after);
/// The same as one line for a person, under load_heading().
std::string load_line(const nlohmann::ordered_json& report);
std::string load_heading();

}  // namespace diaphane::api::load
