#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "operator/plan/world.h"

// What is done next to bring the cluster to what its fleets ask for. Pure (docs/adr/0024): it
// remembers nothing, so whoever leads next goes on where another ended. Actions are carried out in
// their order, each by itself; one that fails is left out, and what follows from that is seen in
// the next world. All of them may be carried out twice.

namespace diaphane::fleet {

enum class Kind { kFleet, kWorker, kPod };

/// Answered by AlreadyExists where another operator was faster: names are the lowest free number
/// of the fleet, so that the same need never makes two.
struct CreateWorker {
  std::string name, fleet, fleet_uid, node, template_hash;
  bool operator==(const CreateWorker&) const = default;
};

/// Of the worker's name and owned by that uid, so that there is one at most; bound to the node by
/// affinity. It tells its epoch with its telemetry.
struct CreatePod {
  std::string worker, worker_uid, node, template_hash;
  std::int64_t epoch = 0;
  bool operator==(const CreatePod&) const = default;
};

struct SetDrain {
  std::string worker, uid, version;
  Drain drain;
  bool operator==(const SetDrain&) const = default;
};

/// Of a node that is gone Kubernetes' own collector takes it.
struct DeletePod {
  std::string name, uid;
  bool operator==(const DeletePod&) const = default;
};

/// The resource stays until its finalizer goes.
struct DeleteWorker {
  std::string name, uid;
  bool operator==(const DeleteWorker&) const = default;
};

struct RemoveFinalizer {
  Kind kind = Kind::kWorker;
  std::string name, uid, version;
  bool operator==(const RemoveFinalizer&) const = default;
};

/// Puts back what we own of an object, by server-side apply: finalizer, labels, owner.
struct Restore {
  Kind kind = Kind::kWorker;
  std::string name, uid;
  bool operator==(const Restore&) const = default;
};

struct SetWorkerStatus {
  std::string name, uid;
  WorkerStatus status;
  bool operator==(const SetWorkerStatus&) const = default;
};

struct SetFleetStatus {
  std::string name, uid;
  FleetStatus status;
};

using Action = std::variant<SetFleetStatus, RemoveFinalizer, Restore, SetDrain, DeleteWorker,
                            DeletePod, CreatePod, CreateWorker, SetWorkerStatus>;

struct Plan {
  std::vector<Action> actions;
  /// After so long there is something to do though nothing is observed.
  std::optional<Seconds> requeue_after;
};

/// Nothing before the world is complete. The same world and seed get the same plan.
Plan plan(const World& world, std::uint64_t seed);

/// The operator's opinion of a worker's heartbeat and of telemetry, by age.
inline constexpr Seconds kHeartbeat = 3;
inline constexpr Seconds kFresh = 10;  ///< older: by counts
/// What is missing in one read may be there all the same: it is believed when it has been so long.
inline constexpr Seconds kConfirmed = 5;
inline constexpr Seconds kExcluded = 60;  ///< older: no new worker on that node

}  // namespace diaphane::fleet
