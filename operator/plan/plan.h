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

/// Creates a worker. Fails with AlreadyExists if another operator was faster: the name is the
/// lowest free number of the fleet, so one need never creates two workers.
struct CreateWorker {
  std::string name, fleet, fleet_uid, node, template_hash;
  bool operator==(const CreateWorker&) const = default;
};

/// Creates the pod of a worker with the worker's name and owner uid, so that there is at most one,
/// and binds it to the node by affinity. The pod reports its epoch with its telemetry.
struct CreatePod {
  std::string worker, worker_uid, node, template_hash;
  std::int64_t epoch = 0;
  int gpus = 1;
  bool operator==(const CreatePod&) const = default;
};

struct SetDrain {
  std::string worker, uid, version;
  Drain drain;
  bool operator==(const SetDrain&) const = default;
};

/// Deletes a pod whose node exists. Kubernetes' garbage collector removes the pods of other nodes.
struct DeletePod {
  std::string name, uid;
  bool operator==(const DeletePod&) const = default;
};

/// Deletes a worker, whose resource remains until its finalizer is removed.
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

/// Returns the next actions, or none until the world is complete. Depends only on `world` and
/// `seed`.
Plan plan(const ClusterState& world, std::uint64_t seed);

/// Maximum age of a worker's heartbeat, and of its telemetry.
inline constexpr Seconds kHeartbeat = directory::kHeartbeatMs / 1000.0;
inline constexpr Seconds kFresh = 10;  ///< of older telemetry, only counts are used
/// An object that is missing in one read may still exist, so its absence counts after this long.
inline constexpr Seconds kConfirmed = 5;
inline constexpr Seconds kExcluded = 60;  ///< with older telemetry, the node gets no new worker

}  // namespace diaphane::fleet
