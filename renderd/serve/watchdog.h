#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "renderd/schedule/progress_monitor.h"

namespace diaphane::render {

/// A thread that detects another thread that hangs: a device that does not respond, or a lock that
/// is never released. Such a process still sends heartbeats and accepts sessions, but shows no
/// pictures. It must exit so that it is restarted and its sessions continue elsewhere.
///
/// The watchdog counts its own polls and reads no clock. A process that was suspended as a whole
/// therefore does not appear to hang, because it missed polls as well as heartbeats.
class Watchdog {
 public:
  struct Watched {
    std::string name;
    /// Changes with each sign of progress; 0 while there is nothing to do. Must not block.
    std::function<std::uint64_t()> pulse;
  };
  struct Options {
    std::chrono::milliseconds limit{10'000};            ///< maximum silence, at least two polls
    std::chrono::milliseconds poll_interval{250};       ///< between two polls
    std::function<void(const std::string& name)> hung;  ///< called once, from the watchdog's thread
  };

  Watchdog(std::vector<Watched> watched, Options options);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Returns whether something has been silent for half of the limit. The process should then
  /// accept no more work.
  bool suspects() const { return suspects_; }

 private:
  void run();
  void poll();

  struct State {
    std::uint64_t pulse = 0;
    std::uint64_t silent_polls = 0;
  };
  const std::vector<Watched> watched_;
  const Options options_;
  std::vector<State> states_;
  std::atomic<bool> suspects_{false};
  bool reported_ = false;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;
};

/// Returns an entry named "device" for each piece of work that a device may have in progress.
/// `monitor` must outlive them.
std::vector<Watchdog::Watched> watched(const ProgressMonitor& monitor);

}  // namespace diaphane::render
