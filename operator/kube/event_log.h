#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace diaphane::kube {

/// Something that is told of an object to whoever asks `kubectl describe`.
struct Happened {
  std::string kind, name, uid;  ///< of the object
  std::string reason;           ///< CamelCase, few
  std::string message;
  bool warning = false;
};

/// The same said again is one Event with a count, written no more often than every `kBetween`; and
/// no object has more than `kBurst` at once, one more every `kRefill`. Pure; times are arguments.
class EventLog {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kForgotten{600};
  static constexpr std::chrono::seconds kBetween{10};
  static constexpr std::chrono::seconds kRefill{60};
  static constexpr int kBurst = 25;

  struct Write {
    std::string name;  ///< of the Event
    int count = 1;     ///< 1: it is to be created; more: its count is to be changed
  };
  /// `run` is in the Events' names, so that those of another run have others.
  explicit EventLog(std::string run) : run_(std::move(run)) {}
  /// Nothing: it is counted and not told now.
  std::optional<Write> note(const Happened& what, Time now);
  std::size_t remembered() const { return told_.size(); }

 private:
  using Key = std::tuple<std::string, std::string, std::string>;  // uid, reason, message
  struct Told {
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
  std::map<Key, Told> told_;
  std::map<std::string, Tokens> tokens_;
  unsigned long number_ = 0;
};

}  // namespace diaphane::kube
