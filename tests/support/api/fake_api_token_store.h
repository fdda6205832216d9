#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "api/accounts/api_tokens.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// API tokens in memory, for tests.
class FakeApiTokenStore final : public ApiTokenStore, public Fake {
 public:
  std::map<std::string, TokenUse> tokens;  ///< by hash
  std::vector<Mail> mails;

  std::set<std::string> ended_sessions;

  Result<bool> create(const std::string& user_id, const std::string& session_id,
                      const ApiToken& token, const std::string& hash, int most,
                      const Mail& notification) override {
    DIAPHANE_TRY(enter("create"));
    if (ended_sessions.contains(session_id)) return fail(ErrorCode::kNotFound, "ended");
    if (static_cast<int>(tokens.size()) >= most) return false;
    tokens[hash] = {token, user_id, "a@example.org", kPrivacyTemplate};
    mails.push_back(notification);
    return true;
  }
  Result<std::vector<ApiToken>> list(const std::string& user_id, Time now) override {
    DIAPHANE_TRY(enter("list"));
    std::vector<ApiToken> found;
    for (const auto& [hash, use] : tokens) {
      if (use.user_id == user_id && use.token.expires_at > now) found.push_back(use.token);
    }
    return found;
  }
  Result<bool> revoke(const std::string& user_id, const std::string& id, Time) override {
    DIAPHANE_TRY(enter("revoke"));
    return std::erase_if(tokens, [&](const auto& one) {
             return one.second.user_id == user_id && one.second.token.id == id;
           }) > 0;
  }
  Result<std::optional<TokenUse>> find(const std::string& hash, Time now) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = tokens.find(hash);
    if (found == tokens.end() || found->second.token.expires_at <= now) return std::nullopt;
    return found->second;
  }
  Result<void> touch(const std::string& id, Time used_at) override {
    DIAPHANE_TRY(enter("touch"));
    for (auto& [hash, use] : tokens) {
      if (use.token.id == id) use.token.used_at = used_at;
    }
    return {};
  }
};

}  // namespace diaphane::api
