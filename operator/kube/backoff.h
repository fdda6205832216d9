#pragma once

#include <chrono>
#include <optional>

namespace diaphane::kube {

/// The pause after a failure. It doubles with each failure, with jitter, and is reset when the last
/// failure was long ago. The numbers are those of client-go's reflector.
class Backoff {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Options {
    std::chrono::milliseconds first{800};
    std::chrono::milliseconds longest{30000};  ///< maximum without jitter
    std::chrono::milliseconds forgotten{120000};
  };

  Backoff() = default;
  explicit Backoff(Options options) : options_(options) {}

  /// Returns the pause after a failure at `now`. `random` in [0, 1) adds up to the same time again,
  /// so that clients that failed together do not retry together.
  std::chrono::milliseconds next(Time now, double random);

 private:
  Options options_;
  std::optional<Time> last_;
  std::chrono::milliseconds delay_{0};
};

}  // namespace diaphane::kube
