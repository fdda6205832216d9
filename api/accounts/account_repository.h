#pragma once

#include "api/accounts/account_store.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Accounts, web sessions and attempts (migrations/0001).
class AccountRepository final : public AccountStore {
 public:
  explicit AccountRepository(Database& database) : database_(database) {}

  Result<void> sign_up(const SignUp& sign_up, Time now) override;
  Result<std::optional<std::string>> find_sign_up(const std::string& token_hash, Time now) override;
  Result<bool> verify(const std::string& token_hash, const std::string& password_hash,
                      Time now) override;
  Result<std::optional<Account>> find_by_email(const std::string& email_key) override;
  Result<std::optional<Account>> find_by_id(const std::string& user_id) override;
  Result<void> open_session(const WebSession& session) override;
  Result<std::optional<SignedIn>> find_session(const std::string& token_hash, Time now) override;
  Result<void> extend_session(const std::string& token_hash, Time expires_at) override;
  Result<void> touch_session(const std::string& token_hash, Time used_at) override;
  Result<void> close_session(const std::string& token_hash) override;
  Result<Quota> quota_of(const std::string& user_id) override;
  Result<std::optional<Time>> consent_at(const std::string& user_id,
                                         const std::string& version) override;
  Result<void> give_consent(const std::string& user_id, const std::string& version,
                            Time now) override;
  Result<std::optional<std::chrono::seconds>> note_attempt(const std::vector<AttemptLimit>& limits,
                                                           Time now) override;
  Result<void> forget_attempts(const std::string& key_hash, std::optional<Time> at) override;
  Result<void> tidy(Time now) override;

 private:
  Database& database_;
};

/// The queue of outgoing mail (migrations/0001).
class MailRepository final : public MailStore {
 public:
  explicit MailRepository(Database& database) : database_(database) {}

  Result<std::optional<Queued>> claim_mail(Time now, std::chrono::seconds lease) override;
  Result<void> mail_sent(std::int64_t id) override;
  Result<void> mail_failed(std::int64_t id, Time not_before) override;

 private:
  Database& database_;
};

/// Ends the web sessions of a user, except `kept_session`, and revokes all API tokens, because
/// someone else may have created them. Their rows stay, as expired, until the streams that they
/// opened have ended (AccountChanges::end_expired_browsers).
void expire_sessions(pqxx::work& transaction, const std::string& user_id,
                     const std::string& kept_session = {});

/// Queues an email, which is sent soon after the transaction commits.
void queue_mail(pqxx::work& transaction, const Mail& mail, Time now);

/// Returns the quota and use of an account in bytes: volumes, labels, and the announced lengths of
/// unfinished uploads. Locks the account until the transaction ends, so that concurrent
/// announcements cannot exceed the quota together.
Quota lock_quota(pqxx::work& transaction, const std::string& user_id);

}  // namespace diaphane::api
