#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "api/accounts/code_check.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Second factors in memory, for tests.
class FakeSecondFactorStore final : public SecondFactorStore, public Fake {
 public:
  std::map<std::string, SecondFactor> factors;         ///< by account
  std::map<std::string, std::set<std::string>> codes;  ///< hashes, by account
  std::vector<Mail> mails;

  Result<std::optional<SecondFactor>> find(const std::string& user_id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = factors.find(user_id);
    if (found == factors.end()) return std::nullopt;
    found->second.recovery_codes = static_cast<int>(codes[user_id].size());
    return found->second;
  }
  Result<bool> begin(const std::string& user_id, const std::string& sealed, Time now) override {
    DIAPHANE_TRY(enter("begin"));
    if (factors.contains(user_id) && factors[user_id].confirmed_at) return false;
    factors[user_id] = {sealed, now, std::nullopt, 0, 0};
    return true;
  }
  Result<bool> confirm(const std::string& user_id, const std::string& sealed, std::int64_t step,
                       const std::vector<std::string>& hashes, const std::string&,
                       const Mail& notification, Time now) override {
    DIAPHANE_TRY(enter("confirm"));
    SecondFactor& factor = factors.at(user_id);
    if (factor.sealed_secret != sealed || factor.confirmed_at) return false;
    factor.confirmed_at = now;
    factor.last_step = step;
    codes[user_id] = {hashes.begin(), hashes.end()};
    mails.push_back(notification);
    return true;
  }
  Result<bool> take_step(const std::string& user_id, std::int64_t step) override {
    DIAPHANE_TRY(enter("take_step"));
    SecondFactor& factor = factors.at(user_id);
    if (factor.last_step >= step) return false;
    factor.last_step = step;
    return true;
  }
  Result<void> note_reuse(const std::string&, const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("note_reuse"));
    mails.push_back(notification);
    return {};
  }
  Result<bool> take_recovery_code(const std::string& user_id, const std::string& hash,
                                  const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("take_recovery_code"));
    if (codes[user_id].erase(hash) == 0) return false;
    mails.push_back(notification);
    return true;
  }
  Result<void> renew_recovery_codes(const std::string& user_id,
                                    const std::vector<std::string>& hashes,
                                    const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("renew_recovery_codes"));
    codes[user_id] = {hashes.begin(), hashes.end()};
    mails.push_back(notification);
    return {};
  }
  Result<void> remove(const std::string& user_id, const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("remove"));
    factors.erase(user_id);
    codes.erase(user_id);
    mails.push_back(notification);
    return {};
  }
};

}  // namespace diaphane::api
