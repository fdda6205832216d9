#pragma once

#include <cstdint>
#include <string_view>

namespace diaphane::api {

/// The languages of emails, the same as those of the page.
enum class Language : std::uint8_t { kEnglish, kGerman };

/// Returns the language that an Accept-Language header (RFC 9110, section 12.5.4) prefers.
/// Returns English if the header names neither language, names English first among equals, is
/// malformed or is longer than 255 bytes.
Language preferred_language(std::string_view accept_language);

}  // namespace diaphane::api
