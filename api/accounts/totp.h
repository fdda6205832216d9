#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// TOTP codes (RFC 6238) with liboath: SHA-1, six digits, 30 s, which every authenticator app
/// supports. The functions keep no state.
namespace diaphane::api::totp {

inline constexpr std::chrono::seconds kStep{30};
inline constexpr std::size_t kDigits = 6;
/// Maximum difference between the two clocks, in steps.
inline constexpr std::int64_t kDrift = 1;

/// Returns 160 random bits as raw bytes (RFC 4226, section 4).
std::string new_secret();
/// Encodes raw bytes for manual entry, in upper case without padding.
std::string base32(std::string_view raw);
/// Returns "otpauth://totp/...", the content of the QR code. `account` may be any text.
std::string uri(std::string_view secret, std::string_view account);

/// Returns the step (30 s units since 1970) that `typed` is the code of, ignoring spaces and
/// dashes. The step must be within kDrift of `now` and later than `after`. Returns nothing
/// otherwise, which includes a code that was used before.
std::optional<std::int64_t> step_of(std::string_view secret, std::string_view typed,
                                    std::chrono::system_clock::time_point now, std::int64_t after);

}  // namespace diaphane::api::totp
