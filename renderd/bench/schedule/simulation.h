#pragma once

#include <string_view>

#include "renderd/bench/schedule/simulated_device.h"

namespace diaphane::render::bench {

struct TraceRun {
  Scores scores;
  DeviceTime time;
};

/// A trace on one simulated device.
TraceRun simulate(const Trace& trace, const DeviceModel& model, std::unique_ptr<Policy> policy,
                  const LedgerRules& rules);

/// Which device a session that comes is put on.
enum class Placement { kSummedError, kLeastCount, kRoundRobin };
inline constexpr Placement kPlacements[] = {Placement::kSummedError, Placement::kLeastCount,
                                            Placement::kRoundRobin};
std::string_view placement_name(Placement placement);

struct FleetRun {
  Scores scores;
  std::size_t fewest = 0, most = 0;  ///< sessions of a device at the end
  double load_deviation = 0;         ///< standard deviation of the devices' busy share
  double seconds = 0;                ///< that the simulation took
};

/// A trace's sessions over `devices` simulated ones; each is put when it comes and stays there, as
/// api/redis/place.lua does it. What a device has is known as it was at its last heartbeat, up to a
/// second ago; a session placed since counts as one with its first picture.
FleetRun simulate_fleet(const Trace& trace, std::size_t devices, const DeviceModel& model,
                        PolicyKind policy, Placement placement, const LedgerRules& rules);

}  // namespace diaphane::render::bench
