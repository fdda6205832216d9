#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace diaphane::render {

/// Per-user GPU time not yet reported to Redis, which counts accounts' render time
/// (docs/contracts.md, "Render time"). Thread-safe.
class GpuTimeMeter {
 public:
  /// Time by user: microseconds in this object, milliseconds in reports.
  using Account = std::map<std::string, std::uint64_t>;

  void add(const std::string& user_id, double seconds) {
    if (user_id.empty() || !(seconds > 0)) return;
    const std::lock_guard lock(mutex_);
    account_[user_id] += static_cast<std::uint64_t>(seconds * 1e6);
  }
  /// Returns the whole milliseconds and keeps the remainders.
  Account take_milliseconds() {
    Account taken;
    const std::lock_guard lock(mutex_);
    for (auto& [user, us] : account_) {
      if (us >= 1000) taken[user] = us / 1000;
      us %= 1000;
    }
    std::erase_if(account_, [](const auto& entry) { return entry.second == 0; });
    return taken;
  }
  /// Adds the time of a failed report again.
  void give_back(const Account& milliseconds) {
    const std::lock_guard lock(mutex_);
    for (const auto& [user, ms] : milliseconds) account_[user] += ms * 1000;
  }

 private:
  std::mutex mutex_;
  Account account_;
};

}  // namespace diaphane::render
