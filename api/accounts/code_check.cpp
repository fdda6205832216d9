#include "api/accounts/code_check.h"

#include <sodium.h>

#include <algorithm>
#include <array>

#include "api/accounts/account_mails.h"
#include "api/accounts/attempts.h"
#include "api/accounts/totp.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr int kRecoveryCodes = 10;
constexpr std::size_t kRecoveryBytes = 15;  ///< 24 characters of base 32, without padding
constexpr std::size_t kRecoveryCharacters = 24;

/// Maps 0, 1 and 8, which Base32 does not have, to the letters they resemble.
char meant(char c) {
  if (c >= 'A' && c <= 'Z') return static_cast<char>(c - 'A' + 'a');
  if (c == '0') return 'o';
  if (c == '1') return 'l';
  if (c == '8') return 'b';
  return c;
}

}  // namespace

std::optional<std::string> recovery_code_hash(std::string_view typed) {
  std::string code(typed);
  std::erase_if(code, [](char c) { return c == ' ' || c == '-'; });
  std::transform(code.begin(), code.end(), code.begin(), meant);
  const bool fits =
      code.size() == kRecoveryCharacters && std::all_of(code.begin(), code.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '2' && c <= '7');
      });
  if (!fits) return std::nullopt;
  return blake2b(code);
}

std::vector<std::string> new_recovery_codes() {
  std::vector<std::string> codes;
  for (int i = 0; i < kRecoveryCodes; ++i) {
    std::array<char, kRecoveryBytes> raw{};
    randombytes_buf(raw.data(), raw.size());
    const std::string letters = totp::base32({raw.data(), raw.size()});
    std::string code;
    for (const char c : letters) {
      if (code.size() % 5 == 4) code += '-';
      code += meant(c);
    }
    codes.push_back(std::move(code));
  }
  return codes;
}

CodeCheck::CodeCheck(SecondFactorStore& store, AccountStore& attempts, const SealingKey& key,
                     const Clock& clock, const Signals& signals, Options options)
    : store_(store),
      attempts_(attempts),
      key_(key),
      clock_(clock),
      signals_(signals),
      options_(std::move(options)) {}

Outcome<bool> CodeCheck::needed(const std::string& user_id) {
  const auto factor = store_.find(user_id);
  if (!factor) return refuse(factor.error());
  return *factor && (*factor)->confirmed_at;
}

Outcome<bool> CodeCheck::take(const std::string& user_id, const std::string& email,
                              const std::string& code, Language language) {
  const auto now = clock_.wall();
  const std::string soon = attempt_key("code", user_id), day = attempt_key("code-day", user_id);
  // The attempt is recorded before the code is checked, as for passwords (accounts.cpp).
  const auto wait = attempts_.note_attempt({{soon, options_.failures, options_.window},
                                            {day, options_.failures_a_day, std::chrono::hours(24)}},
                                           now);
  if (!wait) return refuse(wait.error());
  if (*wait) return too_many_attempts(**wait);
  const auto right = is_right(user_id, email, code, language, now);
  if (!right || !*right) return right;
  for (const std::string& key : {soon, day}) {
    if (auto done = attempts_.forget_attempts(key, std::nullopt); !done) {
      return refuse(done.error());
    }
  }
  return true;
}

Outcome<bool> CodeCheck::was_used(const std::string& user_id, const std::string& email,
                                  Language language, Time now) {
  log::warning("authentication code reused", {{"user", user_id}});
  const auto noted =
      store_.note_reuse(user_id, mails::code_reused(language, email, account_url()), now);
  if (!noted) return refuse(noted.error());
  signals_.raise(Signal::kMail);
  return false;
}

Outcome<bool> CodeCheck::is_right(const std::string& user_id, const std::string& email,
                                  const std::string& code, Language language, Time now) {
  const auto factor = store_.find(user_id);
  if (!factor) return refuse(factor.error());
  if (!*factor || !(*factor)->confirmed_at) return false;
  if (const auto hash = recovery_code_hash(code)) {
    const auto taken = store_.take_recovery_code(
        user_id, *hash, mails::recovery_code_used(language, email, account_url()), now);
    if (!taken) return refuse(taken.error());
    if (*taken) signals_.raise(Signal::kMail);
    return *taken;
  }
  const auto secret = key_.open((*factor)->sealed_secret, user_id);
  if (!secret) {
    log::error("a TOTP secret is sealed with a different key", {{"user", user_id}});
    return refuse(ProblemKind::kInternal,
                  "Authentication codes can't be verified at the moment. Use a recovery code.");
  }
  const auto step = totp::step_of(*secret, code, now, (*factor)->last_step);
  if (!step) {
    const bool used = totp::step_of(*secret, code, now, 0).has_value();
    return used ? was_used(user_id, email, language, now) : Outcome<bool>(false);
  }
  const auto taken = store_.take_step(user_id, *step);
  if (!taken) return refuse(taken.error());
  return *taken ? Outcome<bool>(true) : was_used(user_id, email, language, now);
}

}  // namespace diaphane::api
