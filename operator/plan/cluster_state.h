#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

// The operator's view of a cluster, as plain data. It comes from several caches, so some parts can
// be older than others, and a single read can be wrong. The order of the lists has no meaning.

namespace diaphane::fleet {

/// Seconds since 1970 by the clock of the observer.
using Seconds = double;
using Labels = std::map<std::string, std::string>;

enum class ConditionStatus { kTrue, kFalse, kUnknown };

/// A condition of a status, as in Kubernetes.
struct Condition {
  std::string type;
  ConditionStatus status = ConditionStatus::kUnknown;
  std::string reason;
  std::string message;
  Seconds since = 0;  ///< lastTransitionTime of `status`
  bool operator==(const Condition&) const = default;
};

enum class Strategy {
  kLeastLoaded,  ///< spread
  kPacked        ///< fill nodes, so that others can be released
};

struct Toleration {
  std::string key;     ///< empty: any taint
  std::string value;   ///< empty: any value
  std::string effect;  ///< empty: any effect
  bool operator==(const Toleration&) const = default;
};

struct FleetSpec {
  int sessions_per_worker = 16;  ///< slots
  int gpus_per_worker = 1;       ///< all on one node
  Strategy strategy = Strategy::kLeastLoaded;
  int min_idle_slots = 0;            ///< spare slots
  double max_refill_per_second = 0;  ///< workers to create; 0: no limit
  std::optional<Seconds> scale_to_zero_after;
  Seconds drain_timeout = 300;  ///< grace period of sessions from the start of the drain
  int min_replicas = 0;
  int max_replicas = 1 << 20;
  std::optional<int> replicas;  ///< number set by the scale subresource, regardless of demand
  Labels node_selector;
  std::vector<Toleration> tolerations;
  std::string template_hash;  ///< hash of the pod template
  bool operator==(const FleetSpec&) const = default;
};

/// A node that failed to run a worker and is avoided for a while.
struct NodeBackoff {
  std::string node;
  int count = 0;      ///< refusals, each after the pause of the previous one
  Seconds since = 0;  ///< time of the last refusal
  bool operator==(const NodeBackoff&) const = default;
};

struct FleetStatus {
  std::int64_t observed_generation = 0;
  int replicas = 0;
  int ready_replicas = 0;
  int slots_total = 0;
  int slots_used = 0;
  int slots_reserved = 0;
  std::vector<NodeBackoff> refusals;  ///< sorted by node name
  std::vector<Condition> conditions;  ///< each type at most once
  Seconds written = 0;
  bool operator==(const FleetStatus&) const = default;
};

/// RenderFleet. `version` is the resourceVersion, here and below.
struct Fleet {
  std::string name, uid, version;
  std::int64_t generation = 1;
  std::optional<Seconds> deleted;  ///< deletionTimestamp
  bool finalizer = false;
  FleetSpec spec;
  FleetStatus status;
  bool operator==(const Fleet&) const = default;
};

enum class DrainReason {
  kCordoned,
  kUpgrade,
  kDeleted,
  kIdle,
  kReplicas,
  kUnhealthy,
  kNodeLost,
  kFailing
};

/// A decision to drain a worker. It is never unset, because a draining worker never accepts
/// sessions again. A decision by an operator that has lost its lease is therefore late, but not
/// wrong.
struct Drain {
  DrainReason reason = DrainReason::kDeleted;
  Seconds since = 0;
  bool operator==(const Drain&) const = default;
};

struct WorkerStatus {
  std::int64_t observed_generation = 0;
  std::int64_t epoch = 0;  ///< epoch of its last pod, which counts the pods created
  int failures = 0;        ///< pods that ended since the last one that was ready for two minutes
  std::string failed_pod;  ///< uid of the last failed pod, so that it is counted once
  Seconds failed_at = 0;   ///< time at which that failure was observed
  std::vector<Condition> conditions;
  bool operator==(const WorkerStatus&) const = default;
};

/// RenderWorker: the reservation of GPUs of `node` until the resource is deleted.
struct Worker {
  std::string name, uid, version;
  std::int64_t generation = 1;
  std::string fleet, fleet_uid;
  std::string node;  ///< immutable
  int gpus = 1;      ///< immutable; those of its pod template
  std::string template_hash;
  std::optional<Drain> drain;
  Seconds created = 0;
  std::optional<Seconds> deleted;  ///< deletionTimestamp
  bool finalizer = true;
  bool labelled = true;  ///< labels and owner are unchanged
  WorkerStatus status;
  bool operator==(const Worker&) const = default;
};

enum class Phase { kPending, kRunning, kSucceeded, kFailed, kUnknown };

/// Any pod that has Diaphane's label or is owned by a RenderWorker.
struct Pod {
  std::string name, uid, version;
  bool owned = false;     ///< its controller is a RenderWorker
  std::string owner_uid;  ///< uid of that RenderWorker
  std::int64_t epoch = 0;
  bool labelled = true;  ///< labels are unchanged
  Phase phase = Phase::kPending;
  std::string node;  ///< node that the pod is bound to; empty before
  int gpus = 1;      ///< GPUs that it uses on `node` if a RenderWorker owns it
  bool ready = false;
  Seconds created = 0;
  std::optional<Seconds> unschedulable;  ///< since when the scheduler reports this
  std::optional<Seconds> terminating;    ///< deletionTimestamp
  bool finished() const { return phase == Phase::kSucceeded || phase == Phase::kFailed; }
  bool operator==(const Pod&) const = default;
};

struct Taint {
  std::string key, value, effect;
  bool operator==(const Taint&) const = default;
};

struct Node {
  std::string name;
  int gpus = 0;  ///< allocatable nvidia.com/gpu
  /// GPUs used by pods that no RenderWorker owns, with or without Diaphane's label.
  int foreign_gpus = 0;
  Labels labels;
  std::vector<Taint> taints;
  bool cordoned = false;
  bool ready = true;
  bool operator==(const Node&) const = default;
};

/// The last sample that a pod sent, kept until the next one.
struct Telemetry {
  std::string worker_uid;
  std::int64_t epoch = 0;  ///< epoch of the pod
  Seconds sampled = 0;
  double busy = 0;    ///< share of the device's time, 0 to 1
  double memory = 0;  ///< used share of the memory for loaded volumes, 0 to 1
  int sessions = 0;
  int reserved = 0;  ///< slots assigned to viewers that have not connected yet
  int slots = 0;
  double error = 0;  ///< summed over the pictures of all sessions
  bool draining = false;
  /// Time since which it has had no sessions or reservations; meaningful while it has none.
  Seconds idle_since = 0;
};

/// Demand for one fleet, from Redis.
struct Demand {
  std::string fleet;
  int used = 0;
  int reserved = 0;
  int refused = 0;        ///< requests in the last seconds that found no free slot
  Seconds last_used = 0;  ///< time at which a slot was last used or requested
  Seconds sampled = 0;
};

struct ClusterState {
  Seconds now = 0;
  bool complete = false;  ///< every kind has been listed once
  /// Start of uninterrupted telemetry. Missing telemetry before this time means nothing.
  Seconds listening_since = 0;
  Seconds listened_until = 0;  ///< since then no heartbeat could arrive (Redis is unavailable)
  std::vector<Fleet> fleets;
  std::vector<Worker> workers;
  std::vector<Pod> pods;
  std::vector<Node> nodes;
  std::vector<Telemetry> telemetry;
  std::vector<Demand> demand;
};

}  // namespace diaphane::fleet
