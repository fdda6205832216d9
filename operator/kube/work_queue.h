#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace diaphane::kube {

/// Keys of objects that need work. Only one worker has a key at a time. A key that is added
/// while it is taken is returned again afterwards. A key that is added twice before it is taken is
/// returned once. Failed keys are delayed with a backoff per key. Times are arguments.
class WorkQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kFirst{5};
  static constexpr std::chrono::milliseconds kLongest{1000000};

  /// Makes the key due at `due`, which replaces an earlier time. A key that failed keeps its pause.
  void put(const std::string& key, Time due);
  /// Returns the key that has been due for longest. The caller must then call done(), failed() or
  /// both.
  std::optional<std::string> take(Time now);
  /// Marks a key as no longer taken. It is returned again if it was added meanwhile.
  void done(const std::string& key);
  /// Schedules a retry after a pause of 5 ms, doubled with each failure up to 1000 s.
  void failed(const std::string& key, Time now);
  /// Resets the backoff of a key after success.
  void forget(const std::string& key) { failures_.erase(key); }

  /// Returns when the next key is due.
  std::optional<Time> next() const;
  std::size_t waiting() const { return due_.size(); }
  int failures(const std::string& key) const;

 private:
  struct Failure {
    int count = 0;
    Time until;
  };
  std::map<std::string, Time> due_;
  std::set<std::string> taken_;
  std::map<std::string, Time> again_;  ///< put while taken
  std::map<std::string, Failure> failures_;
};

}  // namespace diaphane::kube
