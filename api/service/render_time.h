#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/service/accounts.h"
#include "api/service/placement.h"

namespace diaphane::api {

/// What an account's pictures may take, and took, of devices this month (UTC).
struct RenderAccount {
  std::int64_t quota_ms = 0, used_ms = 0;
  std::optional<Time> warned_at;  ///< when it was all used
  Time month{};                   ///< its first moment
  Time next_month{};
  bool spent() const { return used_ms >= quota_ms; }
};

/// What workers have noted and nobody has taken yet. Implemented over Redis.
class SpentRenderTime {
 public:
  virtual ~SpentRenderTime() = default;
  /// User and milliseconds; what is taken is nobody else's.
  virtual Result<std::vector<std::pair<std::string, std::int64_t>>> take_render_time() = 0;
};

class RenderTimeStore {
 public:
  virtual ~RenderTimeStore() = default;
  /// Adds to this month's; accounts that there are not are left out. Those whose time is spent are
  /// marked as warned at `now` when they were not before. The ids of those who were warned at
  /// `ended_if_warned_by` or earlier: their grace is over.
  virtual Result<std::vector<std::string>> add(
      const std::vector<std::pair<std::string, std::int64_t>>& spent, Time now,
      Time ended_if_warned_by) = 0;
  /// Marks as warned at `now` whoever has nothing left since the quota became less. The ids of all
  /// who were warned within these times: pictures at rest note nothing, and end all the same.
  virtual Result<std::vector<std::string>> warned(Time now, Time from, Time until) = 0;
  virtual Result<RenderAccount> account(const std::string& user_id, Time now) = 0;
};

/// Render time as a quota: who has spent it opens no more pictures, and those that are open are
/// ended after a grace in which the page says so, also when they are at rest. Thread-safe.
class RenderTime {
 public:
  static constexpr std::chrono::minutes kGrace{2};
  /// For so long after the grace pictures are looked for again that could not be ended at once.
  static constexpr std::chrono::minutes kLookedFor{15};

  RenderTime(RenderTimeStore& store, SpentRenderTime& spent, Placement& placement,
             const Clock& clock)
      : store_(store), spent_(spent), placement_(placement), clock_(clock) {}

  Outcome<RenderAccount> account(const std::string& user_id);
  /// kRenderTimeSpent for a new picture.
  Outcome<void> may_open(const Principal& who);
  /// The same for one that is open, once the grace is over.
  Outcome<void> may_go_on(const Principal& who);
  /// Takes what was noted into the accounts, and ends what has to end; every few seconds.
  void look();

 private:
  RenderTimeStore& store_;
  SpentRenderTime& spent_;
  Placement& placement_;
  const Clock& clock_;
};

}  // namespace diaphane::api
