#include "api/accounts/accounts.h"

#include <algorithm>

#include "api/accounts/account_mails.h"
#include "api/accounts/attempts.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kNonceDigits = 32;

tl::unexpected<Problem> disabled() {
  return refuse(ProblemKind::kDisabled, "An administrator has disabled this account.");
}

}  // namespace

Accounts::Accounts(AccountStore& store, PasswordHasher& hasher, CodeCheck& codes,
                   const SealingKey& key, const Clock& clock, const Signals& signals,
                   Options options)
    : store_(store),
      hasher_(hasher),
      codes_(codes),
      key_(key),
      clock_(clock),
      signals_(signals),
      options_(std::move(options)) {}

std::string Accounts::browser_token(const Account& account, const std::string& nonce) const {
  return nonce +
         key_.mac("known browser\n" + account.id + "\n" + account.password_hash + "\n" + nonce);
}

std::optional<std::string> Accounts::known(const std::optional<Account>& account,
                                           const std::string& cookie) const {
  if (!account || !account->verified || !is_token(cookie)) return std::nullopt;
  std::string nonce = cookie.substr(0, kNonceDigits);
  if (!equal_in_constant_time(cookie, browser_token(*account, nonce))) return std::nullopt;
  return nonce;
}

Outcome<void> Accounts::sign_up(const std::string& email, Consent consent,
                                const std::string& address, Language language) {
  if (!is_email(email)) return refuse_field("email", "Enter a valid email address.");
  if (consent != Consent::kGiven) {
    return refuse_field("consent",
                        "To create an account, agree to the processing of your health data.");
  }

  const auto now = clock_.wall();
  const std::string key = email_key(email);
  const auto wait = store_.note_attempt(
      {{attempt_key("sign-up-address", address), options_.sign_ups_by_address, options_.window}},
      now);
  if (!wait) return refuse(wait.error());
  if (*wait) return too_many_attempts(**wait);

  // Strangers can neither flood a mailbox nor lock out its owner: the limit counts only sign-up
  // emails, and every emailed link works. The response reveals nothing.
  const auto full = store_.note_attempt(
      {{attempt_key(kSignUpMails, key), options_.mails_by_recipient, options_.window}}, now);
  if (!full) return refuse(full.error());
  if (*full) return {};

  const std::string token = random_hex(32);
  const SignUp sign_up{
      new_id(),
      email,
      key,
      blake2b(token),
      now + options_.link_life,
      options_.consent_version,
      mails::welcome(language, email, options_.public_url + "/verify#token=" + token),
      mails::already_there(language, email, options_.public_url + "/")};
  const auto done = store_.sign_up(sign_up, now);
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<Accounts::Opened> Accounts::verify(const std::string& token, const std::string& password,
                                           const std::string& browser) {
  if (!is_token(token)) return refuse_field("token", "This link is incomplete or invalid.");
  const auto too_old = [] {
    return refuse(ProblemKind::kLinkExpired,
                  "This link has expired or was already used. Sign in, or sign up again.");
  };
  const auto now = clock_.wall();
  const auto email = store_.find_sign_up(blake2b(token), now);
  if (!email) return refuse(email.error());
  if (!*email) return too_old();
  if (auto fault = fault_of_password(password, **email)) return refuse_field("password", *fault);
  auto hash = hasher_.hash(password);
  if (!hash) return refuse(hash.error());
  const auto done = store_.verify(blake2b(token), *hash, now);
  if (!done) return refuse(done.error());
  if (!*done) return too_old();
  const auto account = store_.find_by_email(email_key(**email));
  if (!account) return refuse(account.error());
  if (!*account) return too_old();  // deleted in the meantime
  if ((*account)->disabled) return disabled();
  return open(**account, browser, random_hex(kNonceDigits / 2));
}

Outcome<bool> Accounts::is_right(const std::optional<Account>& account, const Counters& counters,
                                 const std::string& password, Time now) {
  std::vector<AttemptLimit> limits{
      {counters.account_key, options_.failures_by_account, options_.window}};
  if (counters.address_key) {
    limits.push_back({*counters.address_key, options_.failures_by_address, options_.window});
  }
  // The attempt is recorded first, so that concurrent attempts cannot exceed the limit.
  const auto wait = store_.note_attempt(limits, now);
  if (!wait) return refuse(wait.error());
  if (*wait) return too_many_attempts(**wait);
  const auto right = account && account->verified ? hasher_.verify(password, account->password_hash)
                                                  : hasher_.verify_dummy(password);
  if (!right) return refuse(right.error());
  if (!*right) return false;
  // A correct password does not count as an attempt. The address keeps its other failures, because
  // an attacker could otherwise clear them with an account of their own.
  if (auto done = store_.forget_attempts(counters.account_key, std::nullopt); !done) {
    return refuse(done.error());
  }
  if (counters.address_key) {
    if (auto done = store_.forget_attempts(*counters.address_key, now); !done) {
      return refuse(done.error());
    }
  }
  return true;
}

Outcome<void> Accounts::check_code(const Account& account, const std::string& code,
                                   Language language) {
  const auto needed = codes_.needed(account.id);
  DIAPHANE_TRY(needed);
  if (!*needed) return {};
  if (code.empty()) {
    return refuse(ProblemKind::kCodeNeeded, "Enter the code from your authenticator app.");
  }
  const auto right = codes_.take(account.id, account.email, code, language);
  DIAPHANE_TRY(right);
  if (!*right) {
    return refuse(
        ProblemKind::kWrongCode,
        "This code is incorrect or was already used. Wait for the next code and try again.");
  }
  return {};
}

Outcome<Accounts::Opened> Accounts::sign_in(const std::string& email, const std::string& password,
                                            const std::string& code, const std::string& address,
                                            const std::string& browser,
                                            const std::string& known_browser, Language language) {
  const auto now = clock_.wall();
  const std::string key = email_key(email);
  const auto account = store_.find_by_email(key);
  if (!account) return refuse(account.error());
  const auto nonce = known(*account, known_browser);
  const Counters counters =
      nonce ? Counters{attempt_key("known-browser", (*account)->id + *nonce), std::nullopt}
            : Counters{attempt_key("account", key), attempt_key("address", address)};
  const auto right = is_right(*account, counters, password, now);
  DIAPHANE_TRY(right);
  if (!*right) {
    return refuse(ProblemKind::kWrongCredentials, "The email address or password is incorrect.");
  }
  if ((*account)->disabled) return disabled();
  DIAPHANE_TRY(check_code(**account, code, language));
  return open(**account, browser, nonce.value_or(random_hex(kNonceDigits / 2)));
}

Outcome<Accounts::Opened> Accounts::open(const Account& account, const std::string& browser,
                                         const std::string& known_browser) {
  const auto now = clock_.wall();
  Opened opened;
  opened.token = random_hex(32);
  const WebSession session{blake2b(opened.token),       account.id, random_hex(32), now,
                           now + options_.session_life, new_id(),   browser};
  if (auto done = store_.open_session(session); !done) return refuse(done.error());
  // The principal is read back, because it depends on the account, such as its administrator role.
  auto principal = authenticate(opened.token);
  DIAPHANE_TRY(principal);
  opened.principal = *std::move(principal);
  opened.known_browser = browser_token(account, known_browser);
  return opened;
}

Outcome<void> Accounts::confirm_password(const Principal& who, const std::string& field,
                                         const std::string& password) {
  const auto account = store_.find_by_id(who.user_id);
  if (!account) return refuse(account.error());
  const Counters counters{attempt_key("confirm", who.user_id + who.session_id), std::nullopt};
  const auto right = is_right(*account, counters, password, clock_.wall());
  DIAPHANE_TRY(right);
  if (!*right) return refuse_field(field, "The password is incorrect.");
  return {};
}

Outcome<void> Accounts::confirm_code(const Principal& who, const std::string& code) {
  return check_code({.id = who.user_id, .email = who.email, .password_hash = {}}, code,
                    who.language);
}

Outcome<void> Accounts::sign_out(const std::string& token) {
  const auto done = store_.close_session(blake2b(token));
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kSignOut);
  return {};
}

Outcome<Principal> Accounts::authenticate(const std::string& token, Renewal renewal) {
  const auto refused = [] { return refuse(ProblemKind::kUnauthenticated, "Sign in to continue."); };
  if (!is_token(token)) return refused();
  const auto now = clock_.wall();
  const std::string hash = blake2b(token);
  const auto found = store_.find_session(hash, now);
  if (!found) return refuse(found.error());
  if (!*found) return refused();
  const WebSession& session = (*found)->session;
  const bool role = (*found)->administrator, factor = (*found)->second_factor;
  if (role && (now - session.created_at >= options_.administrator_limit ||
               now - (*found)->used_at >= options_.administrator_idle)) {
    return refused();
  }
  Principal principal{session.user_id, false,
                      (*found)->email, session.csrf_token,
                      false,           role && factor,
                      session.id,      factor,
                      role && !factor, (*found)->consent_version == options_.consent_version};
  principal.researcher = (*found)->researcher;
  principal.archive_access = (*found)->archive_access;
  if (renewal == Renewal::kNo) return principal;
  if (now - (*found)->used_at > kUseNoted) {
    if (auto done = store_.touch_session(hash, now); !done) return refuse(done.error());
  }

  // Extends the expiry only after a tenth of the lifetime, to avoid a write per request.
  const Time new_expiry =
      std::min(now + options_.session_life,
               session.created_at + (role ? options_.administrator_limit : options_.session_limit));
  // The session of a new administrator becomes shorter. Streams depend on the stored expiry.
  if (new_expiry < session.expires_at) {
    if (auto done = store_.extend_session(hash, new_expiry); !done) return refuse(done.error());
  } else if (new_expiry - session.expires_at > options_.session_life / 10) {
    if (auto done = store_.extend_session(hash, new_expiry); !done) return refuse(done.error());
    principal.renewed = true;
  }
  return principal;
}

Outcome<std::optional<Time>> Accounts::consent_at(const Principal& who) {
  const auto consented_at = store_.consent_at(who.user_id, options_.consent_version);
  if (!consented_at) return refuse(consented_at.error());
  return *consented_at;
}

Outcome<void> Accounts::give_consent(const Principal& who, const std::string& version) {
  if (version != options_.consent_version) {
    return refuse_field("version",
                        "The privacy notice has changed. Reload the page and read it again.");
  }
  const auto done = store_.give_consent(who.user_id, version, clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<Quota> Accounts::quota_of(const std::string& user_id) {
  auto quota = store_.quota_of(user_id);
  if (!quota) return refuse(quota.error());
  return *quota;
}

}  // namespace diaphane::api
