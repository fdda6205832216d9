#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
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

/// Of Redis's answers (observe/fleets.lua), page by page. Whose line makes no sense is left out.
class TelemetryReader {
 public:
  explicit TelemetryReader(const std::vector<std::string>& fleets);
  /// `now` is our own time, at which it came: ages alone are taken from Redis's clock. The cursor
  /// of the next page; kFirstPage: there is none. Nothing where the answer is not one.
  std::optional<std::string> add(const api::redis::Reply& page, Seconds now);
  Reading take() { return std::move(reading_); }

 private:
  void add_worker(std::string_view line, double theirs, Seconds now);

  Reading reading_;
  std::unordered_set<std::string> seen_;  ///< owners
};
inline constexpr std::string_view kFirstPage = "0";

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
  std::unordered_map<std::string, std::map<std::int64_t, Telemetry>> samples_;  // uid, epoch
  std::vector<Demand> demand_;
  Seconds listening_since_ = 0, listened_until_ = 0;
  bool gap_ = true;
};

/// Tells who drains, asks all, page by page. `now` says the time.
Result<Reading> ask_fleets(api::redis::Client& redis, const std::vector<std::string>& fleets,
                           const std::vector<Draining>& draining,
                           const std::function<Seconds()>& now);

}  // namespace diaphane::fleet
