#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace diaphane::kube {

/// Keys of objects that something is to be done about. A key is with one worker at a time; put
/// again meanwhile it comes once more when that one is done; put twice before it is taken it
/// comes once. What fails comes back later and later, each key by its own count. Times are
/// arguments.
class WorkQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kFirst{5};
  static constexpr std::chrono::milliseconds kLongest{1000000};

  /// Due at `due`, whenever it was to come before. A key that failed keeps its pause.
  void put(const std::string& key, Time due);
  /// What has been due for longest; whoever takes it says done, failed or both.
  std::optional<std::string> take(Time now);
  /// Not taken any more. Comes again if it was put in meanwhile.
  void done(const std::string& key);
  /// It is to be tried again after its pause: 5 ms, doubled up to 1000 s.
  void failed(const std::string& key, Time now);
  /// It went well: the next failure is its first.
  void forget(const std::string& key) { failures_.erase(key); }

  /// When something is due next.
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
  std::map<std::string, Time> again_;  ///< put in while taken
  std::map<std::string, Failure> failures_;
};

}  // namespace diaphane::kube
