#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/accounts/password.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Hashes at the lowest cost that argon2 allows. Tests of accounts do not depend on what a hash
/// costs.
class FakePasswordHasher final : public PasswordHasher {
 public:
  FakePasswordHasher()
      : PasswordHasher(2, std::chrono::seconds(2), {.memory_kib = 8, .passes = 1}) {}
};

/// Accounts in memory, for tests.
class FakeAccountStore final : public AccountStore, public Fake {
 public:
  bool administrator = false, second_factor = false;  ///< of the signed-in user
  std::map<std::string, Account> accounts;            ///< by e-mail key
  std::map<std::string, std::string> tokens;          ///< hash to e-mail key
  std::map<std::string, WebSession> sessions;         ///< by token hash
  std::map<std::string, Time> used_at;                ///< of a session, by token hash
  std::vector<std::pair<std::string, Time>> attempts;
  std::vector<Mail> mails;
  std::map<std::string, std::pair<std::string, Time>> consents;  ///< version and time, by user ID
  int extended = 0;

  Result<void> sign_up(const SignUp& s, Time now) override {
    DIAPHANE_TRY(enter("sign_up"));
    auto& account = accounts[s.email_key];
    if (account.verified) {
      mails.push_back(s.already_there);
      return {};
    }
    if (account.id.empty()) account = {s.user_id, s.email, "", false, false};
    consents[account.id] = {s.consent_version, now};
    tokens[s.token_hash] = s.email_key;
    mails.push_back(s.welcome);
    return {};
  }
  Result<std::optional<std::string>> find_sign_up(const std::string& token_hash, Time) override {
    DIAPHANE_TRY(enter("find_sign_up"));
    const auto found = tokens.find(token_hash);
    if (found == tokens.end()) return std::nullopt;
    return accounts[found->second].email;
  }
  Result<bool> verify(const std::string& token_hash, const std::string& password_hash,
                      Time) override {
    DIAPHANE_TRY(enter("verify"));
    const auto found = tokens.find(token_hash);
    if (found == tokens.end()) return false;
    const std::string email = found->second;
    accounts[email].verified = true;
    accounts[email].password_hash = password_hash;
    std::erase_if(tokens, [&](const auto& token) { return token.second == email; });
    return true;
  }
  Result<std::optional<Account>> find_by_email(const std::string& key) override {
    DIAPHANE_TRY(enter("find_by_email"));
    const auto found = accounts.find(key);
    return found == accounts.end() ? std::nullopt : std::optional(found->second);
  }
  Result<std::optional<Account>> find_by_id(const std::string& id) override {
    DIAPHANE_TRY(enter("find_by_id"));
    for (const auto& [key, account] : accounts) {
      if (account.id == id) return account;
    }
    return std::nullopt;
  }
  Result<void> open_session(const WebSession& session) override {
    DIAPHANE_TRY(enter("open_session"));
    sessions[session.token_hash] = session;
    used_at[session.token_hash] = session.created_at;
    return {};
  }
  Result<std::optional<SignedIn>> find_session(const std::string& hash, Time now) override {
    DIAPHANE_TRY(enter("find_session"));
    const auto found = sessions.find(hash);
    if (found == sessions.end() || found->second.expires_at <= now) return std::nullopt;
    return SignedIn{found->second, "person@example.org", administrator,
                    used_at[hash], second_factor,        consents[found->second.user_id].first};
  }
  Result<void> extend_session(const std::string& hash, Time expires_at) override {
    DIAPHANE_TRY(enter("extend_session"));
    sessions.at(hash).expires_at = expires_at;
    ++extended;
    return {};
  }
  Result<void> touch_session(const std::string& hash, Time at) override {
    DIAPHANE_TRY(enter("touch_session"));
    used_at[hash] = at;
    return {};
  }
  Result<void> close_session(const std::string& hash) override {
    DIAPHANE_TRY(enter("close_session"));
    sessions.erase(hash);
    return {};
  }
  Result<Quota> quota_of(const std::string&) override {
    DIAPHANE_TRY(enter("quota_of"));
    return Quota{1000, 0};
  }
  Result<std::optional<Time>> consent_at(const std::string& id,
                                         const std::string& version) override {
    DIAPHANE_TRY(enter("consent_at"));
    const auto found = consents.find(id);
    if (found == consents.end() || found->second.first != version) return std::nullopt;
    return found->second.second;
  }
  Result<void> give_consent(const std::string& id, const std::string& version, Time now) override {
    DIAPHANE_TRY(enter("give_consent"));
    consents[id] = {version, now};
    return {};
  }
  Result<std::optional<std::chrono::seconds>> note_attempt(const std::vector<AttemptLimit>& limits,
                                                           Time now) override {
    DIAPHANE_TRY(enter("note_attempt"));
    for (const AttemptLimit& limit : limits) {
      const auto recent = std::count_if(attempts.begin(), attempts.end(), [&](const auto& a) {
        return a.first == limit.key_hash && a.second > now - limit.window;
      });
      if (recent >= limit.count) return limit.window;
    }
    for (const AttemptLimit& limit : limits) attempts.emplace_back(limit.key_hash, now);
    return std::nullopt;
  }
  Result<void> forget_attempts(const std::string& key, std::optional<Time> at) override {
    DIAPHANE_TRY(enter("forget_attempts"));
    std::erase_if(attempts,
                  [&](const auto& a) { return a.first == key && (!at || a.second == *at); });
    return {};
  }
  Result<void> tidy(Time) override {
    DIAPHANE_TRY(enter("tidy"));
    return {};
  }
};

}  // namespace diaphane::api
