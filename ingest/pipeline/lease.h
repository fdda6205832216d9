#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>

namespace diaphane::ingest {

/// Who claims jobs of a queue in Postgres, and for how long.
struct LeaseOptions {
  std::string url;
  std::string claimer;  ///< identifies this worker in leases; different at each start
  std::chrono::milliseconds lease{5000};
};

/// Returns the Builder::ShouldContinue of a claimed job. It returns false once the worker is
/// stopping. Otherwise it calls `renew` every `every` and returns its result, and true in between.
/// `renew` renews the lease and returns whether the job is still held. It should return true while
/// Postgres is unavailable, because no other worker can claim the job then either.
inline std::function<bool()> renewing(std::function<bool()> is_stopping,
                                      std::chrono::milliseconds every,
                                      std::function<bool()> renew) {
  using Clock = std::chrono::steady_clock;
  return [is_stopping = std::move(is_stopping), every, renew = std::move(renew),
          next = Clock::now() + every]() mutable {
    if (is_stopping()) return false;
    if (Clock::now() < next) return true;
    next = Clock::now() + every;
    return renew();
  };
}

}  // namespace diaphane::ingest
