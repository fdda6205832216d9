#pragma once

#include <chrono>

namespace diaphane::service {

/// Turns SIGTERM and SIGINT into a value that the main thread waits for, and ignores SIGPIPE.
/// Construct it before any other thread starts. Threads inherit the signal mask, so no thread of a
/// library is interrupted.
class StopSignal {
 public:
  StopSignal();
  /// Blocks until a signal arrives and returns its number.
  int wait();
  /// Returns true if a signal arrives within `timeout`.
  bool wait_for(std::chrono::milliseconds timeout);
};

}  // namespace diaphane::service
