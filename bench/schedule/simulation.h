#pragma once

#include <string_view>

#include "bench/schedule/simulated_device.h"

namespace diaphane::render::bench {

struct TraceRun {
  Scores scores;
  DeviceTime time;
};

/// Plays a trace on one simulated device.
TraceRun simulate(const Trace& trace, const DeviceModel& model, std::unique_ptr<Policy> policy,
                  const LedgerRules& rules);

/// How the device for a new session is chosen.
enum class Placement { kSummedError, kLeastCount, kRoundRobin };
inline constexpr Placement kPlacements[] = {Placement::kSummedError, Placement::kLeastCount,
                                            Placement::kRoundRobin};
std::string_view placement_name(Placement placement);

struct FleetRun {
  Scores scores;
  std::size_t fewest = 0, most = 0;  ///< sessions per device at the end
  double load_deviation = 0;         ///< standard deviation of the devices' busy share
  double seconds = 0;                ///< duration of the simulation
};

/// Plays a trace on `devices` simulated devices. Each session is placed when it arrives and stays
/// there, as in directory/scripts/place.lua. The load of a device is known as of its last
/// heartbeat, up to a second ago. A session placed since counts as one with its first picture.
FleetRun simulate_fleet(const Trace& trace, std::size_t devices, const DeviceModel& model,
                        PolicyKind policy, Placement placement, const LedgerRules& rules);

}  // namespace diaphane::render::bench
