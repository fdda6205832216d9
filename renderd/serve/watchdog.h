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

#include "renderd/schedule/signs.h"

namespace diaphane::render {

/// A thread that notices when another one hangs: a device that does not answer, a lock that is
/// never given back. Such a process still beats and takes sessions, and nobody sees a picture; it
/// must end, so that it is started again and its sessions go on elsewhere.
///
/// It counts its own looks and reads no clock: a process that was stopped as a whole and goes on
/// has missed looks as well as signs of life, and is not taken for one that hangs.
class Watchdog {
 public:
  struct Watched {
    std::string name;
    /// Changes with each sign of life; 0 while there is nothing to do. Must not block.
    std::function<std::uint64_t()> pulse;
  };
  struct Options {
    std::chrono::milliseconds limit{10'000};            ///< of silence, at least two looks
    std::chrono::milliseconds look{250};                ///< between two looks
    std::function<void(const std::string& name)> hung;  ///< called once, from the watchdog's thread
  };

  Watchdog(std::vector<Watched> watched, Options options);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Something has been silent for half of the limit: no more work should come here.
  bool suspects() const { return suspects_; }

 private:
  void run();
  void look();

  struct State {
    std::uint64_t pulse = 0;
    std::uint64_t silent_looks = 0;
  };
  const std::vector<Watched> watched_;
  const Options options_;
  std::vector<State> states_;
  std::atomic<bool> suspects_{false};
  bool told_ = false;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;
};

/// Each piece of work under way on a device, all by the name "device". `signs` must outlive them.
std::vector<Watchdog::Watched> watched(const Signs& signs);

}  // namespace diaphane::render
