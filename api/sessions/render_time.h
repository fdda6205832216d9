#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/placement.h"
#include "directory/workers.h"

namespace diaphane::api {

/// Rendering time of an account this month (UTC): its quota and its use.
struct RenderAccount {
  std::int64_t quota_ms = 0, used_ms = 0;
  std::optional<Time> warned_at;  ///< when the quota was used up
  Time month{};                   ///< the start of the month
  Time next_month{};
  bool spent() const { return used_ms >= quota_ms; }
};

using directory::SpentRenderTime;

/// Stores rendering time, in milliseconds of a device. Every function returns kUnavailable if the
/// database is unavailable.
class RenderTimeStore {
 public:
  virtual ~RenderTimeStore() = default;
  /// Adds to this month's use and skips unknown accounts. Marks accounts without time left as
  /// warned at `now` unless they already are. Returns the IDs of accounts that were warned at
  /// `ended_if_warned_by` or earlier, whose grace period is over.
  virtual Result<std::vector<std::string>> add(
      const std::vector<std::pair<std::string, std::int64_t>>& spent, Time now,
      Time ended_if_warned_by) = 0;
  /// Marks accounts as warned at `now` if a lower quota left them without time. Returns the IDs of
  /// all accounts warned in this range, because idle sessions report no time and must end as well.
  virtual Result<std::vector<std::string>> warned(Time now, Time from, Time until) = 0;
  /// Returns kNotFound for an unknown user.
  virtual Result<RenderAccount> account(const std::string& user_id, Time now) = 0;
};

/// Enforces the quota of rendering time. An account without time left can open no sessions. Its
/// open sessions, idle ones included, end after a grace period with a notice. Thread-safe.
class RenderTime {
 public:
  static constexpr std::chrono::minutes kGrace{2};
  /// Time after the grace period during which ending the sessions is retried.
  static constexpr std::chrono::minutes kSearchWindow{15};

  RenderTime(RenderTimeStore& store, SpentRenderTime& spent, Placement& placement,
             const Clock& clock)
      : store_(store), spent_(spent), placement_(placement), clock_(clock) {}

  Outcome<RenderAccount> account(const std::string& user_id);
  /// Returns kRenderTimeSpent if no time is left for a new session.
  Outcome<void> may_open(const Principal& who);
  /// Returns kRenderTimeSpent for an open session once the grace period is over.
  Outcome<void> may_go_on(const Principal& who);
  /// Charges the reported time and ends sessions after the grace period. Call it every few seconds.
  void poll();

 private:
  RenderTimeStore& store_;
  SpentRenderTime& spent_;
  Placement& placement_;
  const Clock& clock_;
};

}  // namespace diaphane::api
