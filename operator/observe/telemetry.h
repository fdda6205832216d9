#pragma once

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "api/redis/client.h"
#include "operator/plan/world.h"

namespace diaphane::fleet {

/// What a look into Redis brought.
struct Reading {
  std::vector<Telemetry> telemetry;
  std::vector<Demand> demand;
};

/// A RenderWorker whose pod is to be told that it drains.
struct Draining {
  std::string worker;
  std::string owner;  ///< owner_text of its pod
};

/// Of Redis's answer (observe/fleets.lua); `now` is our own time, at which it came: ages alone are
/// taken from Redis's clock.
Reading read_telemetry(const api::redis::Reply& reply, const std::vector<std::string>& fleets,
                       Seconds now);

/// The last sample of each pod, kept when it says no more. Thread-safe.
class TelemetryBook {
 public:
  void note(Reading reading, Seconds now);
  /// Redis did not answer.
  void missed();
  /// Puts what is known into `world`, and forgets pods of workers that it does not have.
  void fill(World& world);

 private:
  std::mutex mutex_;
  std::map<std::pair<std::string, std::int64_t>, Telemetry> samples_;  // worker's uid, epoch
  std::vector<Demand> demand_;
  Seconds listening_since_ = 0, listened_until_ = 0;
  bool gap_ = true;
};

/// One round trip: tells who drains, asks all.
Result<api::redis::Reply> ask_fleets(api::redis::Client& redis,
                                     const std::vector<std::string>& fleets,
                                     const std::vector<Draining>& draining);

}  // namespace diaphane::fleet
