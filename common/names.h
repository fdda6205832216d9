#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace diaphane {

/// Cleans a name so that it can be shown to others: valid UTF-8 without control, direction and
/// invisible characters, with single spaces and at most `most` characters. It may be empty.
std::string clean_name(std::string_view typed, std::size_t most);

/// Returns whether a clean name cannot be mistaken for anything else, even in an email to a
/// stranger. It has only letters, digits, spaces, apostrophes, hyphens and full stops at the end of
/// a word, and thus no address, host name, link, parenthesis or quotation mark.
bool is_plain_name(std::string_view clean);

}  // namespace diaphane
