#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace diaphane::kube {

/// An event of an object, as shown by `kubectl describe`.
struct Happened {
  std::string kind, name, uid;  ///< the object of the event
  std::string reason;           ///< CamelCase, from a small set
  std::string message;
  bool warning = false;
};

/// Merges repeated events into one Event with a count, which is written at most once per
/// `kBetween`. Limits each object to a burst of `kBurst` events, refilled by one per `kRefill`.
/// Pure. Times are arguments.
class EventLog {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kForgotten{600};
  static constexpr std::chrono::seconds kBetween{10};
  static constexpr std::chrono::seconds kRefill{60};
  static constexpr int kBurst = 25;

  struct Write {
    std::string name;  ///< name of the Event
    int count = 1;     ///< 1: create the Event; more: update its count
  };
  /// `run` is part of the Events' names, so that they differ between runs.
  explicit EventLog(std::string run) : run_(std::move(run)) {}
  /// Records an event. Returns nullopt if it is only counted for now.
  std::optional<Write> note(const Happened& what, Time now);
  std::size_t remembered() const { return written_.size(); }

 private:
  using Key = std::tuple<std::string, std::string, std::string>;  // uid, reason, message
  struct Written {
    std::string name;
    int count = 0;
    Time first, last_seen, last_written;
  };
  struct Tokens {
    double count = kBurst;
    Time at;
  };
  void forget(Time now);

  std::string run_;
  std::map<Key, Written> written_;
  std::map<std::string, Tokens> tokens_;
  unsigned long number_ = 0;
};

}  // namespace diaphane::kube
