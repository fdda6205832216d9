#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "api/http/executor.h"
#include "api/routing/request_router.h"
#include "common/result.h"

namespace diaphane::api {

/// Wraps cpprestsdk's HTTP listener on 127.0.0.1, which only the edge may reach. The library's
/// threads never block: they read the head, start reading the body and hand the request over to the
/// executor, which runs the handler.
class Listener {
 public:
  struct Options {
    std::uint16_t port = 0;
    int library_threads = 3;
    /// Maximum total size of bodies in memory. Further requests get 503.
    std::int64_t body_budget = std::int64_t{128} << 20;
  };

  /// Returns kUnavailable if the port is in use. `router` and `executor` must outlive the listener.
  /// Call it only once per process.
  static Result<std::unique_ptr<Listener>> open(const RequestRouter& router, Executor& executor,
                                                Options options);
  ~Listener();

  /// Refuses new requests with 503 and `Connection: close`, and waits up to `patience` for requests
  /// in progress. The port stays open until the process exits or the destructor runs: while the
  /// library closes a listener, it answers 404 to every request that still arrives.
  void drain(std::chrono::milliseconds patience);

 private:
  struct Impl;
  explicit Listener(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api
