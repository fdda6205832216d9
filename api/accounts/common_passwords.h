#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace diaphane::api {

/// Explains why a password is easy to guess, or returns nothing. A password is easy to guess if it
/// is in common_passwords.txt, is such a word (or `user_word` or the service's name) with a few
/// digits or symbols around it, repeats something short, or counts up or down. The case is ignored.
/// `user_word` must be in lower case.
std::optional<std::string> weakness_of(std::string_view password, std::string_view user_word);

}  // namespace diaphane::api
