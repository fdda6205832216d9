#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "api/service/problem.h"

/// What is limited by count, as AccountStore::note_attempt keeps it.
namespace diaphane::api {

/// The key of attempts of a kind ("account", "address", "mail") by somebody.
std::string attempt_key(std::string_view what, std::string_view whose);
/// kTooManyAttempts, with the wait in words.
tl::unexpected<Problem> too_many_attempts(std::chrono::seconds wait);

}  // namespace diaphane::api
