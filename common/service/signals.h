#pragma once

#include <chrono>

namespace diaphane::service {

/// SIGTERM and SIGINT become a value that the main thread waits for. Construct it before any other
/// thread starts: the mask is inherited, so that no library's thread is interrupted. SIGPIPE is
/// ignored.
class StopSignal {
 public:
  StopSignal();
  /// Blocks until a signal came; its number.
  int wait();
  /// True once a signal came within `timeout`.
  bool wait_for(std::chrono::milliseconds timeout);
};

}  // namespace diaphane::service
