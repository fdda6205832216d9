#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace diaphane {

/// A name as others may see it: valid UTF-8 without control, direction and invisible characters,
/// spaces single, at most `most` characters. May be empty.
std::string clean_name(std::string_view typed, std::size_t most);

/// Whether a clean name can be taken for nothing but a name, also in a mail to a stranger: letters,
/// digits, spaces, apostrophes, hyphens, and a full stop that ends a word. So it holds no address,
/// no host name, no link and no quotation mark.
bool is_plain_name(std::string_view clean);

}  // namespace diaphane
