#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// One-time codes by time (RFC 6238) over liboath: SHA-1, six digits, 30 s, which is what every
/// authenticator reads. Pure.
namespace diaphane::api::totp {

inline constexpr std::chrono::seconds kStep{30};
inline constexpr std::size_t kDigits = 6;
/// How many steps the two clocks may be apart.
inline constexpr std::int64_t kDrift = 1;

/// 160 random bits, raw (RFC 4226, section 4).
std::string new_secret();
/// As a person types it: upper case, without padding. Of raw bytes.
std::string base32(std::string_view raw);
/// "otpauth://totp/...", what the QR code holds. `account` is any text.
std::string uri(std::string_view secret, std::string_view account);

/// The step (of 30 s since 1970) whose code `typed` is, blanks and dashes aside: at most kDrift
/// from that of `now`, and later than `after`. Nothing: it is none of those, so also one that was
/// used before.
std::optional<std::int64_t> step_of(std::string_view secret, std::string_view typed,
                                    std::chrono::system_clock::time_point now, std::int64_t after);

}  // namespace diaphane::api::totp
