#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "api/service/problem.h"

/// What is limited by count, as AccountStore::note_attempt keeps it.
namespace diaphane::api {

/// Kinds of mails that strangers can cause, each counted by its recipient on its own: none of them
/// can use up the room of another.
inline constexpr std::string_view kSignUpMails = "mail-sign-up";
inline constexpr std::string_view kResetMails = "mail-reset";
inline constexpr std::string_view kChangeMails = "mail-change";

/// The key of attempts of a kind ("account", "address", kSignUpMails) by somebody.
std::string attempt_key(std::string_view what, std::string_view whose);
/// kTooManyAttempts, with the wait in words.
tl::unexpected<Problem> too_many_attempts(std::chrono::seconds wait);

}  // namespace diaphane::api
