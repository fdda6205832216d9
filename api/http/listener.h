#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "api/handlers/front.h"
#include "api/http/executor.h"
#include "common/result.h"

namespace diaphane::api {

/// cpprestsdk's listener on 127.0.0.1, tamed: it must never face the network itself (design: edge).
/// A library thread only reads the head, starts the reading of the body, and hands over to the
/// executor.
class Listener {
 public:
  struct Options {
    std::uint16_t port = 0;
    int library_threads = 3;
    /// Bodies in memory at once, in all; whoever comes besides gets 503.
    std::int64_t body_budget = std::int64_t{128} << 20;
  };

  /// kUnavailable when the port is taken. `front` and `executor` must outlive the listener. Once a
  /// process.
  static Result<std::unique_ptr<Listener>> open(const Front& front, Executor& executor,
                                                Options options);
  ~Listener();

  /// Refuses what is new with 503 and `Connection: close`, waits up to `patience` for what is in
  /// flight, closes.
  void drain(std::chrono::milliseconds patience);

 private:
  struct Impl;
  explicit Listener(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api
