#pragma once

#include <cstdint>
#include <string_view>

namespace diaphane::api {

/// The languages of emails, the same as those of the page.
enum class Language : std::uint8_t { kEnglish, kGerman };

/// Returns the language that an Accept-Language header (RFC 9110, section 12.5.4) prefers.
/// English, if it names neither language, or both equally with English first, or is malformed.
/// Nothing else of the header is used. Reads at most 255 bytes and 32 languages.
Language preferred_language(std::string_view accept_language);

}  // namespace diaphane::api
