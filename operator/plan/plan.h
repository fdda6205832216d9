#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "directory/constants.h"
#include "operator/plan/cluster_state.h"

// The next actions that bring the cluster to the state that its fleets specify. The plan is a pure
// function (docs/adr/0024) without memory, so a new leader continues where the last one stopped.
// Actions are executed in order and independently. A failed action is skipped, and the next world
// shows the consequences. Every action can safely be executed twice.

namespace diaphane::fleet {

enum class Kind { kFleet, kWorker, kPod };

/// Fails with AlreadyExists if another operator was faster. The name is the lowest free number of
/// the fleet, so that one need never creates two workers.
struct CreateWorker {
  std::string name, fleet, fleet_uid, node, template_hash;
  bool operator==(const CreateWorker&) const = default;
};

/// The pod has the worker's name and owner uid, so that there is at most one, and is bound to the
/// node by affinity. It reports its epoch with its telemetry.
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

/// Kubernetes' garbage collector removes the pods of a node that no longer exists.
struct DeletePod {
  std::string name, uid;
  bool operator==(const DeletePod&) const = default;
};

/// The resource remains until its finalizer is removed.
struct DeleteWorker {
  std::string name, uid;
  bool operator==(const DeleteWorker&) const = default;
};

struct RemoveFinalizer {
  Kind kind = Kind::kWorker;
  std::string name, uid, version;
  bool operator==(const RemoveFinalizer&) const = default;
};

/// Restores the fields that the operator owns by server-side apply: finalizer, labels, owner.
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
  /// Time after which to plan again even if nothing changes.
  std::optional<Seconds> requeue_after;
};

/// Empty until the world is complete. The same world and seed give the same plan.
Plan plan(const ClusterState& world, std::uint64_t seed);

/// Maximum age of a worker's heartbeat, and of its telemetry.
inline constexpr Seconds kHeartbeat = directory::kHeartbeatMs / 1000.0;
inline constexpr Seconds kFresh = 10;  ///< older: only counts are used
/// An object that is missing in one read may still exist, so its absence counts after this long.
inline constexpr Seconds kConfirmed = 5;
inline constexpr Seconds kExcluded = 60;  ///< older: no new worker on the node

}  // namespace diaphane::fleet
