#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

// What the operator sees of a cluster, as plain data. Whoever fills it in has it from several
// caches, so parts may be older than others, and one read may be wrong. The order within the lists
// is of no meaning.

namespace diaphane::fleet {

/// Since 1970, by the clock of whoever observes.
using Seconds = double;
using Labels = std::map<std::string, std::string>;

enum class Truth { kTrue, kFalse, kUnknown };

/// Of a status, as Kubernetes has them.
struct Condition {
  std::string type;
  Truth status = Truth::kUnknown;
  std::string reason;
  std::string message;
  Seconds since = 0;  ///< lastTransitionTime: of `status`
  bool operator==(const Condition&) const = default;
};

enum class Strategy {
  kLeastLoaded,  ///< spread
  kPacked        ///< fill nodes, so that others can be given back
};

struct Toleration {
  std::string key;     ///< empty: every taint
  std::string value;   ///< empty: every value
  std::string effect;  ///< empty: every effect
  bool operator==(const Toleration&) const = default;
};

struct FleetSpec {
  int sessions_per_worker = 16;  ///< slots
  Strategy strategy = Strategy::kLeastLoaded;
  int min_idle_slots = 0;            ///< warm
  double max_refill_per_second = 0;  ///< workers; 0: no limit
  std::optional<Seconds> scale_to_zero_after;
  Seconds drain_timeout = 300;  ///< grace of sessions, from the drain's begin
  int min_replicas = 0;
  int max_replicas = 1 << 20;
  std::optional<int> replicas;  ///< by the scale subresource: so many, whatever the demand
  Labels node_selector;
  std::vector<Toleration> tolerations;
  std::string template_hash;  ///< of the pod template
  bool operator==(const FleetSpec&) const = default;
};

/// A node that did not take a worker, and is not asked again for a while.
struct Refusal {
  std::string node;
  int count = 0;      ///< each after the pause of the one before
  Seconds since = 0;  ///< of the last
  bool operator==(const Refusal&) const = default;
};

struct FleetStatus {
  std::int64_t observed_generation = 0;
  int replicas = 0;
  int ready_replicas = 0;
  int slots_total = 0;
  int slots_used = 0;
  int slots_reserved = 0;
  std::vector<Refusal> refusals;      ///< by node name
  std::vector<Condition> conditions;  ///< each type once
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

/// Once set it stays: a worker that drains never takes sessions again. So a decision of an operator
/// that has meanwhile lost its lease is late, and not wrong.
struct Drain {
  DrainReason reason = DrainReason::kDeleted;
  Seconds since = 0;
  bool operator==(const Drain&) const = default;
};

struct WorkerStatus {
  std::int64_t observed_generation = 0;
  std::int64_t epoch = 0;  ///< of its last pod: how many were made
  int failures = 0;        ///< pods that ended, since the last that was ready for two minutes
  std::string failed_pod;  ///< uid of the last of them: counted once
  Seconds failed_at = 0;   ///< when that was seen
  std::vector<Condition> conditions;
  bool operator==(const WorkerStatus&) const = default;
};

/// RenderWorker: the reservation of one GPU of `node`, until the resource has gone.
struct Worker {
  std::string name, uid, version;
  std::int64_t generation = 1;
  std::string fleet, fleet_uid;
  std::string node;  ///< immutable
  std::string template_hash;
  std::optional<Drain> drain;
  Seconds created = 0;
  std::optional<Seconds> deleted;  ///< deletionTimestamp
  bool finalizer = true;
  bool labelled = true;  ///< labels and owner are as they were made
  WorkerStatus status;
  bool operator==(const Worker&) const = default;
};

enum class Phase { kPending, kRunning, kSucceeded, kFailed, kUnknown };

/// Every pod that has our label or is owned by a RenderWorker.
struct Pod {
  std::string name, uid, version;
  bool owned = false;     ///< its controller is a RenderWorker
  std::string owner_uid;  ///< of that
  std::int64_t epoch = 0;
  bool labelled = true;  ///< labels are as they were made
  Phase phase = Phase::kPending;
  std::string node;  ///< bound to; empty before
  bool ready = false;
  Seconds created = 0;
  std::optional<Seconds> unschedulable;  ///< since when the scheduler says so
  std::optional<Seconds> terminating;    ///< deletionTimestamp
  bool operator==(const Pod&) const = default;
};

struct Taint {
  std::string key, value, effect;
  bool operator==(const Taint&) const = default;
};

struct Node {
  std::string name;
  int gpus = 0;          ///< allocatable nvidia.com/gpu
  int foreign_gpus = 0;  ///< of pods that no RenderWorker owns, with our label or without
  Labels labels;
  std::vector<Taint> taints;
  bool cordoned = false;
  bool ready = true;
  bool operator==(const Node&) const = default;
};

/// The last sample that a pod pushed; it stays until there is another.
struct Telemetry {
  std::string worker_uid;
  std::int64_t epoch = 0;  ///< of the pod
  Seconds sampled = 0;
  double busy = 0;    ///< of the device, 0 to 1
  double memory = 0;  ///< of the device, 0 to 1
  int sessions = 0;
  int reserved = 0;  ///< slots given away whose viewer has not come yet
  int slots = 0;
  double error = 0;  ///< of all its sessions' pictures, summed
  bool draining = false;
  Seconds idle_since = 0;  ///< without sessions and reservations since; of use while it has none
};

/// Of one fleet, by Redis.
struct Demand {
  std::string fleet;
  int used = 0;
  int reserved = 0;
  int refused = 0;        ///< in the last seconds, for want of a slot
  Seconds last_used = 0;  ///< when a slot was last used or asked for
  Seconds sampled = 0;
};

struct World {
  Seconds now = 0;
  bool complete = false;  ///< every kind has been listed once
  /// To telemetry, without a gap; its absence before means nothing.
  Seconds listening_since = 0;
  Seconds listened_until = 0;  ///< since then nobody could be heard (Redis is away)
  std::vector<Fleet> fleets;
  std::vector<Worker> workers;
  std::vector<Pod> pods;
  std::vector<Node> nodes;
  std::vector<Telemetry> telemetry;
  std::vector<Demand> demand;
};

}  // namespace diaphane::fleet
