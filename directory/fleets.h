#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "directory/client.h"

namespace diaphane::directory {

/// Demand for the slots of one fleet.
struct FleetDemand {
  int refused = 0;    ///< sessions that found no slot within the last kUnplacedMs
  double idle_s = 0;  ///< time since a slot was last in use or requested without success
};

/// The last report of a fleet's worker.
struct WorkerReport {
  std::string owner;  ///< as in FleetReport
  double age_s = 0;
  double busy = 0;    ///< share of the device used in the second before the report, 0 to 1
  double memory = 0;  ///< used share of the memory for loaded volumes, 0 to 1
  int sessions = 0;
  int used = 0;  ///< occupied slots: sessions and reservations
  int slots = 0;
  double error = 0;  ///< sum of the errors of all its pictures
  bool draining = false;
  double idle_s = 0;  ///< time since it last had a slot in use
};

struct FleetPage {
  std::string next;                 ///< cursor of the next page; kFirstPage after the last one
  std::vector<FleetDemand> demand;  ///< demand for the requested fleets, in their order
  /// A worker that joins or leaves between pages may be missing, and any may be on two pages.
  std::vector<WorkerReport> workers;
};
inline constexpr std::string_view kFirstPage = "0";

/// A worker that is to drain.
struct DrainRequest {
  std::string worker_id;
  std::string owner;  ///< ignored by a worker with another owner
};

/// Reads one page of all workers, with the demand for `fleets`, and sends the drain requests, which
/// expire after kDrainMs. Sessions refused without a fleet count for the first one.
Result<FleetPage> read_fleets(Client& client, std::string_view cursor,
                              const std::vector<std::string>& fleets,
                              const std::vector<DrainRequest>& draining);

}  // namespace diaphane::directory
