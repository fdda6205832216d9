#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/shared/problem.h"

namespace diaphane::api {

/// Maximum size of a stored answer (migrations/0028).
inline constexpr std::size_t kMostAnswerBytes = 16'384;

/// Returns the step of a definition with this ID, or null.
const nlohmann::json* find_step(const nlohmann::json& definition, const std::string& id);

/// Checks the value of an answer to `step`, a step of a checked definition. Returns the value in its
/// stored form, or kInvalid with the field "value".
Outcome<std::string> check_answer(const nlohmann::json& step, const nlohmann::json& value);

}  // namespace diaphane::api
