#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "api/shared/problem.h"

/// Rate limits that AccountStore::note_attempt counts.
namespace diaphane::api {

/// The types of emails that strangers can trigger. Each type is counted separately per recipient,
/// so that no type can exhaust the limit of another.
inline constexpr std::string_view kSignUpMails = "mail-sign-up";
inline constexpr std::string_view kResetMails = "mail-reset";
inline constexpr std::string_view kChangeMails = "mail-change";

/// Returns the key of attempts of a type ("account", "address", kSignUpMails) by one source.
std::string attempt_key(std::string_view what, std::string_view whose);
/// Returns kTooManyAttempts with a sentence that states the waiting time.
tl::unexpected<Problem> too_many_attempts(std::chrono::seconds wait);

}  // namespace diaphane::api
