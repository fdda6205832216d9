#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "api/sessions/render_time.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Rendering time of accounts in memory, for tests. An unknown account has an hour left.
class FakeRenderTimeStore final : public RenderTimeStore, public Fake {
 public:
  std::map<std::string, RenderAccount> accounts;  ///< by user

  Result<std::vector<std::string>> add(
      const std::vector<std::pair<std::string, std::int64_t>>& spent, Time now,
      Time ended_if_warned_by) override {
    DIAPHANE_TRY(enter("add"));
    std::vector<std::string> over;
    for (const auto& [user, ms] : spent) {
      const auto found = accounts.find(user);
      if (found == accounts.end()) continue;
      RenderAccount& account = found->second;
      account.used_ms += ms;
      if (account.spent() && !account.warned_at) account.warned_at = now;
      if (account.warned_at && *account.warned_at <= ended_if_warned_by) over.push_back(user);
    }
    return over;
  }
  Result<std::vector<std::string>> warned(Time now, Time from, Time until) override {
    DIAPHANE_TRY(enter("warned"));
    std::vector<std::string> found;
    for (auto& [user, account] : accounts) {
      if (account.spent() && !account.warned_at) account.warned_at = now;
      if (account.warned_at && *account.warned_at >= from && *account.warned_at <= until) {
        found.push_back(user);
      }
    }
    return found;
  }
  Result<RenderAccount> account(const std::string& user_id, Time) override {
    DIAPHANE_TRY(enter("account"));
    const auto found = accounts.find(user_id);
    return found == accounts.end() ? RenderAccount{.quota_ms = 3'600'000} : found->second;
  }
};

/// Reports of workers, for tests.
class FakeSpentRenderTime final : public SpentRenderTime, public Fake {
 public:
  std::vector<std::pair<std::string, std::int64_t>> reported;  ///< user and milliseconds

  Result<std::vector<std::pair<std::string, std::int64_t>>> take_render_time() override {
    DIAPHANE_TRY(enter("take_render_time"));
    return std::exchange(reported, {});
  }
};

}  // namespace diaphane::api
