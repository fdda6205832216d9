#include "api/accounts/totp.h"

#include <liboath/oath.h>
#include <sodium.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <stdexcept>

#include "api/shared/secrets.h"

namespace diaphane::api::totp {
namespace {

constexpr std::size_t kSecretBytes = 20;

void check(int code) {
  if (code != OATH_OK) throw std::runtime_error(oath_strerror(code));
}

std::string code_of(std::string_view secret, std::int64_t step) {
  static const bool ready = oath_init() == OATH_OK;
  if (!ready) throw std::runtime_error("cannot initialise liboath");
  std::array<char, kDigits + 1> code{};
  check(oath_hotp_generate(secret.data(), secret.size(), static_cast<std::uint64_t>(step), kDigits,
                           false, OATH_HOTP_DYNAMIC_TRUNCATION, code.data()));
  return code.data();
}

/// Escapes all but unreserved characters as %XX (RFC 3986).
std::string escaped(std::string_view text) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~';
    const auto byte = static_cast<unsigned char>(c);
    out += plain ? std::string(1, c) : std::string{'%', kHex[byte >> 4], kHex[byte & 15]};
  }
  return out;
}

}  // namespace

std::string new_secret() {
  std::string raw(kSecretBytes, '\0');
  randombytes_buf(raw.data(), raw.size());
  return raw;
}

std::string base32(std::string_view raw) {
  char* text = nullptr;
  std::size_t size = 0;
  check(oath_base32_encode(raw.data(), raw.size(), &text, &size));
  const std::unique_ptr<char, void (*)(void*)> owner(text, std::free);
  std::string out(text, size);
  return out.substr(0, out.find('='));
}

std::string uri(std::string_view secret, std::string_view account) {
  return "otpauth://totp/Diaphane:" + escaped(account) + "?secret=" + base32(secret) +
         "&issuer=Diaphane&algorithm=SHA1&digits=" + std::to_string(kDigits) +
         "&period=" + std::to_string(kStep.count());
}

std::optional<std::int64_t> step_of(std::string_view secret, std::string_view typed,
                                    std::chrono::system_clock::time_point now, std::int64_t after) {
  std::string code(typed);
  std::erase_if(code, [](char c) { return c == ' ' || c == '-'; });
  const std::int64_t current_step = now.time_since_epoch() / kStep;
  std::optional<std::int64_t> found;
  for (std::int64_t step = current_step - kDrift; step <= current_step + kDrift; ++step) {
    const bool same = equal_in_constant_time(code_of(secret, step), code);
    if (same && step > after && !found) found = step;
  }
  return found;
}

}  // namespace diaphane::api::totp
