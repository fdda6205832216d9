#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "directory/fleets.h"
#include "operator/plan/cluster_state.h"

namespace diaphane::fleet {

/// The result of one query to Redis.
struct Reading {
  std::vector<Telemetry> telemetry;
  std::vector<Demand> demand;
};

/// Collects the pages of the session directory. A worker without a valid owner is skipped.
class TelemetryReader {
 public:
  explicit TelemetryReader(const std::vector<std::string>& fleets);
  /// `now` is the local time of receipt. Only ages are taken from the clock of Redis.
  void add(const directory::FleetPage& page, Seconds now);
  Reading take() { return std::move(reading_); }

 private:
  void add_worker(const directory::WorkerReport& report, Seconds now);

  Reading reading_;
  std::unordered_set<std::string> seen_;  ///< owners of the workers added so far
};

/// The last sample of each pod, also kept after its heartbeat stops. Thread-safe.
class TelemetryCache {
 public:
  void note(Reading reading, Seconds now);
  /// Records that Redis did not answer.
  void missed();
  /// Adds the known samples to `world`, and forgets pods of workers that it does not contain.
  void fill(ClusterState& world);

 private:
  std::mutex mutex_;
  std::unordered_map<std::string, std::map<std::int64_t, Telemetry>> samples_;  // uid, epoch
  std::vector<Demand> demand_;
  Seconds listening_since_ = 0, listened_until_ = 0;
  bool gap_ = true;
};

/// Reports draining workers to Redis and queries all fleets, page by page. `now` returns the time.
Result<Reading> ask_fleets(directory::Client& redis, const std::vector<std::string>& fleets,
                           const std::vector<directory::DrainRequest>& draining,
                           const std::function<Seconds()>& now);

}  // namespace diaphane::fleet
