#include "api/accounts/second_factor.h"

#include "api/accounts/account_mails.h"
#include "api/accounts/totp.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

std::vector<std::string> hashes_of(const std::vector<std::string>& codes) {
  std::vector<std::string> hashes;
  for (const std::string& code : codes) hashes.push_back(recovery_code_hash(code).value());
  return hashes;
}

tl::unexpected<Problem> wrong_code() {
  return refuse_field(
      "code", "This code is incorrect or was already used. Wait for the next code and try again.");
}

tl::unexpected<Problem> not_begun() {
  return refuse(
      ProblemKind::kConflict,
      "The setup of two-factor authentication has expired or was never started. Start again.");
}

}  // namespace

SecondFactors::SecondFactors(SecondFactorStore& store, Accounts& accounts, CodeCheck& codes,
                             const SealingKey& key, const Clock& clock, const Signals& signals,
                             Options options)
    : store_(store),
      accounts_(accounts),
      codes_(codes),
      key_(key),
      clock_(clock),
      signals_(signals),
      options_(options) {}

Outcome<SecondFactorState> SecondFactors::state(const Principal& who) {
  const auto factor = store_.find(who.user_id);
  if (!factor) return refuse(factor.error());
  SecondFactorState state;
  state.required = who.administrator || who.administrator_waits;
  if (*factor && (*factor)->confirmed_at) {
    state.set_up_at = (*factor)->confirmed_at;
    state.recovery_codes = (*factor)->recovery_codes;
  }
  return state;
}

Outcome<NewSecondFactor> SecondFactors::begin(const Principal& who, const std::string& password) {
  DIAPHANE_TRY(accounts_.confirm_password(who, "password", password));
  const std::string secret = totp::new_secret();
  const auto begun = store_.begin(who.user_id, key_.seal(secret, who.user_id), clock_.wall());
  if (!begun) return refuse(begun.error());
  if (!*begun) {
    return refuse(ProblemKind::kConflict,
                  "Two-factor authentication is already on. Turn it off first.");
  }
  return NewSecondFactor{totp::base32(secret), totp::uri(secret, who.email)};
}

Outcome<std::vector<std::string>> SecondFactors::confirm(const Principal& who,
                                                         const std::string& code) {
  const auto now = clock_.wall();
  const auto factor = store_.find(who.user_id);
  if (!factor) return refuse(factor.error());
  if (!*factor || (*factor)->confirmed_at || (*factor)->begun_at + options_.begun_life < now) {
    return not_begun();
  }
  const auto secret = key_.open((*factor)->sealed_secret, who.user_id);
  if (!secret) return not_begun();
  const auto step = totp::step_of(*secret, code, now, (*factor)->last_step);
  if (!step) return wrong_code();
  auto codes = new_recovery_codes();
  const auto done = store_.confirm(
      who.user_id, (*factor)->sealed_secret, *step, hashes_of(codes), who.session_id,
      mails::second_factor_added(who.language, who.email, codes_.account_url()), now);
  if (!done) return refuse(done.error());
  if (!*done) return not_begun();
  signals_.raise(Signal::kSignOut);
  signals_.raise(Signal::kMail);
  return codes;
}

Outcome<void> SecondFactors::confirm_both(const Principal& who, const std::string& password,
                                          const std::string& code) {
  if (!who.second_factor) {
    return refuse(ProblemKind::kConflict, "Two-factor authentication is not on for your account.");
  }
  if (auto right = accounts_.confirm_password(who, "password", password); !right) {
    return right;
  }
  const auto right = codes_.take(who.user_id, who.email, code, who.language);
  DIAPHANE_TRY(right);
  if (!*right) return wrong_code();
  return {};
}

Outcome<std::vector<std::string>> SecondFactors::renew_recovery_codes(const Principal& who,
                                                                      const std::string& password,
                                                                      const std::string& code) {
  DIAPHANE_TRY(confirm_both(who, password, code));
  auto codes = new_recovery_codes();
  const auto done = store_.renew_recovery_codes(
      who.user_id, hashes_of(codes),
      mails::recovery_codes_renewed(who.language, who.email, codes_.account_url()), clock_.wall());
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kMail);
  return codes;
}

Outcome<void> SecondFactors::remove(const Principal& who, const std::string& password,
                                    const std::string& code) {
  if (auto right = confirm_both(who, password, code); !right) return right;
  const auto done = store_.remove(
      who.user_id, mails::second_factor_removed(who.language, who.email, codes_.account_url()),
      clock_.wall());
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kMail);
  return {};
}

}  // namespace diaphane::api
