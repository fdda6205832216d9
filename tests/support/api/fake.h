#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "common/result.h"

namespace diaphane::api {

/// Base of the fakes in tests. Every function of a fake first calls `enter` with its own name, so
/// that a test can count the calls, make the function fail, or run code just before it, as a
/// concurrent request would.
class Fake {
 public:
  bool away = false;  ///< makes every function return kUnavailable

  void break_function(const std::string& name, ErrorCode code = ErrorCode::kUnavailable,
                      const std::string& field = {}) {
    const std::lock_guard lock(mutex_);
    broken_[name] = Error{code, "broken by the test", field};
  }
  void repair(const std::string& name) {
    const std::lock_guard lock(mutex_);
    broken_.erase(name);
  }
  void before(const std::string& name, std::function<void()> act) {
    const std::lock_guard lock(mutex_);
    before_[name] = std::move(act);
  }
  int calls(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = calls_.find(name);
    return found == calls_.end() ? 0 : found->second;
  }

 protected:
  ~Fake() = default;

  Result<void> enter(const std::string& name) {
    std::function<void()> act;
    {
      const std::lock_guard lock(mutex_);
      ++calls_[name];
      if (const auto found = before_.find(name); found != before_.end()) act = found->second;
    }
    if (act) act();
    const std::lock_guard lock(mutex_);
    if (away) return fail(ErrorCode::kUnavailable, "away");
    const auto found = broken_.find(name);
    if (found != broken_.end()) return tl::unexpected<Error>(found->second);
    return {};
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Error> broken_;
  std::map<std::string, std::function<void()>> before_;
  std::map<std::string, int> calls_;
};

}  // namespace diaphane::api
