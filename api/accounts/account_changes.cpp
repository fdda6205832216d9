#include "api/accounts/account_changes.h"

#include "api/accounts/account_mails.h"
#include "api/accounts/attempts.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr int kBrowsersAtOnce = 1000;

tl::unexpected<Problem> too_old() {
  return refuse(ProblemKind::kLinkExpired,
                "This link has expired or was already used. Request a new one.");
}

}  // namespace

AccountChanges::AccountChanges(AccountChangeStore& store, AccountStore& attempts,
                               Accounts& accounts, PasswordHasher& hasher, Placement& placement,
                               const Clock& clock, const Signals& signals, Options options)
    : store_(store),
      attempts_(attempts),
      accounts_(accounts),
      hasher_(hasher),
      placement_(placement),
      clock_(clock),
      signals_(signals),
      options_(std::move(options)) {}

void AccountChanges::end_pictures(const std::string& user_id) {
  // Redis may be unavailable. No new session can be opened with the revoked access, and running
  // sessions end within a day at the latest.
  if (!placement_.end_all_by(user_id)) log::warning("failed to end an account's sessions");
}

Outcome<void> AccountChanges::request_reset(const std::string& email, const std::string& address,
                                            Language language) {
  if (!is_email(email)) return refuse_field("email", "Enter a valid email address.");
  const auto now = clock_.wall();
  const std::string key = email_key(email);
  const auto wait = attempts_.note_attempt(
      {{attempt_key("reset-address", address), options_.resets_by_address, options_.window}}, now);
  if (!wait) return refuse(wait.error());
  if (*wait) return too_many_attempts(**wait);
  // The response does not reveal that the limit was reached, as for sign-up.
  const auto full = attempts_.note_attempt(
      {{attempt_key(kResetMails, key), options_.mails_by_recipient, options_.window}}, now);
  if (!full) return refuse(full.error());
  if (*full) return {};

  const std::string token = random_hex(32);
  const auto done = store_.request_reset(
      key, blake2b(token), now + options_.reset_life,
      {mails::reset(language, email, options_.public_url + "/reset#token=" + token),
       mails::account_disabled(language, email, options_.public_url + "/contact"),
       mails::no_account(language, email, options_.public_url + "/sign-up")});
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<void> AccountChanges::reset(const std::string& token, const std::string& password,
                                    Language language) {
  if (!is_token(token)) return refuse_field("token", "This link is incomplete or invalid.");
  const auto now = clock_.wall();
  const std::string token_hash = blake2b(token);
  const auto bearer = store_.find_token(token_hash, "reset", now);
  if (!bearer) return refuse(bearer.error());
  if (!*bearer) return too_old();
  const TokenBearer& person = **bearer;
  if (auto fault = fault_of_password(password, person.email)) {
    return refuse_field("password", *fault);
  }
  auto hash = hasher_.hash(password);
  if (!hash) return refuse(hash.error());
  const auto done = store_.reset(
      token_hash, *hash, mails::password_changed(language, person.email, forgot_url()), now);
  if (!done) return refuse(done.error());
  if (!*done) return too_old();
  // Clears the failures, so that the reader of the mailbox can sign in however often others have
  // guessed.
  (void)attempts_.forget_attempts(attempt_key("account", email_key(person.email)), std::nullopt);
  end_pictures(person.user_id);
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<void> AccountChanges::change_password(const Principal& who, const std::string& current,
                                              const std::string& password) {
  if (auto fault = fault_of_password(password, who.email)) return refuse_field("password", *fault);
  if (auto right = accounts_.confirm_password(who, "current", current); !right) {
    return right;
  }
  auto hash = hasher_.hash(password);
  if (!hash) return refuse(hash.error());
  const auto done = store_.change_password(
      who.user_id, *hash, who.session_id,
      mails::password_changed(who.language, who.email, forgot_url()), clock_.wall());
  if (!done) return refuse(done.error());
  end_pictures(who.user_id);
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<void> AccountChanges::request_email(const Principal& who, const std::string& new_email,
                                            const std::string& password) {
  if (!is_email(new_email)) return refuse_field("email", "Enter a valid email address.");
  const std::string key = email_key(new_email);
  if (key == email_key(who.email))
    return refuse_field("email", "This is already your email address.");
  if (auto right = accounts_.confirm_password(who, "password", password); !right) {
    return right;
  }
  const auto now = clock_.wall();
  const auto full = attempts_.note_attempt(
      {{attempt_key(kChangeMails, key), options_.mails_by_recipient, options_.window},
       {attempt_key("change", who.user_id), options_.mails_by_recipient, options_.window}},
      now);
  if (!full) return refuse(full.error());
  if (*full) return too_many_attempts(**full);
  const std::string token = random_hex(32);
  const EmailRequest request{
      who.user_id,
      new_email,
      key,
      blake2b(token),
      now + options_.change_life,
      mails::confirm_new_address(who.language, new_email,
                                 options_.public_url + "/confirm-email#token=" + token),
      mails::new_address_taken(who.language, new_email, options_.public_url + "/"),
      mails::address_change_requested(who.language, who.email, forgot_url())};
  if (const auto done = store_.request_email(request, now); !done) return refuse(done.error());
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<void> AccountChanges::confirm_email(const Principal& who, const std::string& token) {
  if (!is_token(token)) return refuse_field("token", "This link is incomplete or invalid.");
  const auto now = clock_.wall();
  const std::string token_hash = blake2b(token);
  const auto bearer = store_.find_token(token_hash, "change", now);
  if (!bearer) return refuse(bearer.error());
  if (!*bearer) return too_old();
  if ((*bearer)->user_id != who.user_id) {
    return refuse(ProblemKind::kForbidden,
                  "This link belongs to a different account. Sign in to the account that requested "
                  "the change, then open the link again.");
  }
  const auto done =
      store_.confirm_email(token_hash, email_key((*bearer)->new_email),
                           mails::address_changed(who.language, (*bearer)->email), now);
  if (!done) return refuse(done.error());
  if (!*done) return too_old();
  signals_.raise(Signal::kMail);
  return {};
}

Outcome<std::vector<BrowserSession>> AccountChanges::browser_sessions(const Principal& who) {
  auto found = store_.browser_sessions(who.user_id, clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> AccountChanges::end_browser_session(const Principal& who, const std::string& id) {
  const auto none = [] { return refuse(ProblemKind::kNotFound, "Session not found."); };
  if (!is_id(id)) return none();
  const auto done = store_.end_browser_session(who.user_id, id);
  if (!done) return refuse(done.error());
  if (!*done) return none();
  end_expired_browsers();
  return {};
}

void AccountChanges::end_expired_browsers() {
  const auto expired = store_.expired_browsers(clock_.wall(), kBrowsersAtOnce);
  if (!expired) return;
  for (const ExpiredBrowser& browser : *expired) {
    if (!placement_.end_all_from(browser.id, browser.user_id)) return;
    (void)store_.forget_browser(browser.id);
  }
}

Outcome<void> AccountChanges::sign_out_everywhere(const Principal& who) {
  const auto done = store_.end_browser_sessions(who.user_id, clock_.wall());
  if (!done) return refuse(done.error());
  end_pictures(who.user_id);
  return {};
}

}  // namespace diaphane::api
