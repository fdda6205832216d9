#pragma once

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>

#include "common/fd.h"

namespace diaphane {

/// Bounds the time that a library waits on a socket, where the library has no limit of its own
/// (libpq while it waits for an answer). When a deadline passes, the connection is shut down, so
/// that the wait ends as if the peer had closed it. This also covers a peer whose process is frozen
/// while its kernel still acknowledges every packet, which TCP's own timeouts never notice.
/// Thread-safe.
class SocketDeadlines {
 public:
  using SteadyTime = std::chrono::steady_clock::time_point;

  SocketDeadlines();
  ~SocketDeadlines();
  SocketDeadlines(const SocketDeadlines&) = delete;
  SocketDeadlines& operator=(const SocketDeadlines&) = delete;

 private:
  struct Entry {
    Fd socket;  ///< a duplicate, because the library may close its own and the number may be reused
    SteadyTime deadline;
    bool passed = false;
  };

 public:
  /// One wait, from construction to destruction.
  class Guard {
   public:
    Guard(SocketDeadlines& deadlines, int socket, SteadyTime deadline);
    ~Guard();
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;
    /// Returns whether the connection was shut down because the deadline passed.
    bool passed() const;

   private:
    SocketDeadlines& deadlines_;
    std::list<Entry>::iterator entry_;
  };

 private:
  void run();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Entry> entries_;
  SteadyTime next_ = SteadyTime::max();  ///< when the thread wakes up unless notified
  bool stopping_ = false;
  std::thread thread_;  // last, because it uses the other members
};

}  // namespace diaphane
