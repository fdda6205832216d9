#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace diaphane::api {

/// Why somebody who guesses would come upon this password soon, or nothing: it is on the list of
/// common_passwords.txt, is such a one (or `own_word`, or the service's name) with a few digits or
/// signs before or behind, repeats something short, or counts up or down. In whatever case.
/// `own_word` is in lower case.
std::optional<std::string> why_easily_guessed(std::string_view password, std::string_view own_word);

}  // namespace diaphane::api
