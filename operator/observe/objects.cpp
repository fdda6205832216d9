#include "operator/observe/objects.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "operator/kube/api.h"
#include "operator/kube/fields.h"
#include "operator/kube/informer.h"
#include "operator/names.h"
#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

using kube::number;
using kube::part;
using kube::text;

std::optional<Seconds> time(const Json& object, const char* key) {
  return kube::time_of(text(object, key));
}

Labels labels(const Json& object) {
  Labels labels;
  if (!object.is_object()) return labels;
  for (const auto& [key, value] : object.items()) {
    if (value.is_string()) labels.emplace(key, value.get<std::string>());
  }
  return labels;
}

struct Owner {
  std::string name, uid;
};

/// Returns the controller of an object if it is of this kind and of Diaphane's API group.
std::optional<Owner> owner(const Json& metadata, const char* kind) {
  const Json& all = part(metadata, "ownerReferences");
  if (!all.is_array()) return std::nullopt;
  for (const Json& one : all) {
    const Json& controls = part(one, "controller");
    if (!controls.is_boolean() || !controls.get<bool>() || text(one, "kind") != kind) continue;
    if (text(one, "apiVersion").rfind(std::string(kGroup) + "/", 0) != 0) continue;
    return Owner{text(one, "name"), text(one, "uid")};
  }
  return std::nullopt;
}

/// Parses a quantity of GPUs: an integer, or one with a suffix, which is unusual for GPUs.
int quantity(const Json& value) {
  if (value.is_number_integer()) return value.get<int>();
  if (!value.is_string()) return 0;
  const auto& digits = value.get_ref<const std::string&>();
  int count = 0;
  const auto [end, wrong] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  if (wrong != std::errc()) return 0;
  return end != digits.data() + digits.size() && *end == 'k' ? count * 1000 : count;
}

std::vector<Condition> conditions(const Json& status) {
  std::vector<Condition> conditions;
  const Json& all = part(status, "conditions");
  if (!all.is_array()) return conditions;
  for (const Json& one : all) {
    Condition condition;
    condition.type = text(one, "type");
    const std::string value = text(one, "status");
    condition.status = value == "True"    ? ConditionStatus::kTrue
                       : value == "False" ? ConditionStatus::kFalse
                                          : ConditionStatus::kUnknown;
    condition.reason = text(one, "reason");
    condition.message = text(one, "message");
    condition.since = time(one, "lastTransitionTime").value_or(0);
    conditions.push_back(std::move(condition));
  }
  return conditions;
}

FleetStatus fleet_status(const Json& status) {
  FleetStatus read;
  read.observed_generation = number<std::int64_t>(status, "observedGeneration", 0);
  read.replicas = number(status, "replicas", 0);
  read.ready_replicas = number(status, "readyReplicas", 0);
  read.slots_total = number(status, "slotsTotal", 0);
  read.slots_used = number(status, "slotsUsed", 0);
  read.slots_reserved = number(status, "slotsReserved", 0);
  read.written = time(status, "written").value_or(0);
  read.conditions = conditions(status);
  if (const Json& all = part(status, "refusals"); all.is_array()) {
    for (const Json& one : all) {
      read.refusals.push_back(
          {text(one, "node"), number(one, "count", 1), time(one, "since").value_or(0)});
    }
  }
  return read;
}

FleetSpec fleet_spec(const Json& spec) {
  FleetSpec read;
  read.sessions_per_worker = number(spec, "sessionsPerWorker", read.sessions_per_worker);
  read.gpus_per_worker = number(spec, "gpusPerWorker", read.gpus_per_worker);
  read.strategy = text(spec, "strategy") == "Packed" ? Strategy::kPacked : Strategy::kLeastLoaded;
  read.min_idle_slots = number(part(spec, "warm"), "minIdleSlots", 0);
  read.max_refill_per_second = number(part(spec, "warm"), "maxRefillPerSecond", 0.0);
  read.scale_to_zero_after = duration_of(text(spec, "scaleToZeroAfter"));
  read.drain_timeout = duration_of(text(spec, "drainTimeout")).value_or(read.drain_timeout);
  read.min_replicas = number(spec, "minReplicas", 0);
  read.max_replicas = number(spec, "maxReplicas", read.max_replicas);
  if (part(spec, "replicas").is_number()) read.replicas = number(spec, "replicas", 0);
  read.node_selector = labels(part(spec, "nodeSelector"));
  const Json& pods = part(spec, "template");
  if (const Json& all = part(part(pods, "spec"), "tolerations"); all.is_array()) {
    for (const Json& one : all) {
      read.tolerations.push_back({text(one, "key"), text(one, "value"), text(one, "effect")});
    }
  }
  return read;
}

std::optional<DrainReason> drain_reason(const std::string& name) {
  for (const DrainReason reason :
       {DrainReason::kCordoned, DrainReason::kUpgrade, DrainReason::kDeleted, DrainReason::kIdle,
        DrainReason::kReplicas, DrainReason::kUnhealthy, DrainReason::kNodeLost,
        DrainReason::kFailing}) {
    if (to_string(reason) == name) return reason;
  }
  return std::nullopt;
}

Phase phase_of(const std::string& name) {
  if (name == "Pending") return Phase::kPending;
  if (name == "Running") return Phase::kRunning;
  if (name == "Succeeded") return Phase::kSucceeded;
  if (name == "Failed") return Phase::kFailed;
  return Phase::kUnknown;
}

int gpus_of(const Json& spec) {
  int gpus = 0;
  if (const Json& all = part(spec, "containers"); all.is_array()) {
    for (const Json& one : all) {
      const Json& resources = part(one, "resources");
      const int limit = quantity(part(part(resources, "limits"), kGpu));
      gpus += limit > 0 ? limit : quantity(part(part(resources, "requests"), kGpu));
    }
  }
  return gpus;
}

}  // namespace

bool has_finalizer(const Json& metadata) {
  const Json& all = part(metadata, "finalizers");
  return all.is_array() && std::find(all.begin(), all.end(), kFinalizer) != all.end();
}

bool equal_except_version(FleetObject a, const FleetObject& b) {
  a.version = b.version;
  a.fleet.version = b.fleet.version;
  if (a.pods && b.pods && *a.pods == *b.pods) a.pods = b.pods;
  return a == b;
}

bool equal_except_version(WorkerObject a, const WorkerObject& b) {
  a.version = b.version;
  a.worker.version = b.worker.version;
  return a == b;
}

bool equal_except_version(PodObject a, const PodObject& b) {
  a.version = b.version;
  a.pod.version = b.pod.version;
  return a == b;
}

bool equal_except_version(NodeObject a, const NodeObject& b) {
  a.version = b.version;
  return a == b;
}

Template Templates::intern(const std::string& hash, const Json& pods) {
  const std::lock_guard lock(mutex_);
  std::erase_if(known_, [](const auto& one) { return one.second.expired(); });
  auto& known = known_[hash];
  // A hash alone could match two templates that were written by hand.
  if (Template shared = known.lock(); shared && *shared == pods) return shared;
  auto fresh = std::make_shared<const Json>(pods);
  known = fresh;
  return fresh;
}

std::optional<FleetObject> read_fleet(const Json& object) {
  const Json& metadata = part(object, "metadata");
  FleetObject read;
  Fleet& fleet = read.fleet;
  read.name = fleet.name = text(metadata, "name");
  read.uid = fleet.uid = text(metadata, "uid");
  read.version = fleet.version = text(metadata, "resourceVersion");
  if (read.name.empty()) return std::nullopt;
  fleet.generation = number<std::int64_t>(metadata, "generation", 1);
  fleet.deleted = time(metadata, "deletionTimestamp");
  fleet.finalizer = has_finalizer(metadata);
  fleet.spec = fleet_spec(part(object, "spec"));
  fleet.status = fleet_status(part(object, "status"));
  read.pods = std::make_shared<const Json>(
      worker_template(part(part(object, "spec"), "template"), fleet.spec));
  fleet.spec.template_hash = template_hash(*read.pods);
  return read;
}

std::optional<WorkerObject> read_worker(const Json& object, Templates& templates) {
  const Json& metadata = part(object, "metadata");
  const Json& spec = part(object, "spec");
  const Json& status = part(object, "status");
  WorkerObject read;
  Worker& worker = read.worker;
  read.name = worker.name = text(metadata, "name");
  read.uid = worker.uid = text(metadata, "uid");
  read.version = worker.version = text(metadata, "resourceVersion");
  if (read.name.empty()) return std::nullopt;
  worker.generation = number<std::int64_t>(metadata, "generation", 1);
  worker.fleet = text(spec, "fleetName");
  worker.fleet_uid = text(spec, "fleetUid");
  worker.node = text(spec, "nodeName");
  worker.template_hash = text(spec, "templateHash");
  if (const auto reason = drain_reason(text(part(spec, "drain"), "reason"))) {
    worker.drain = Drain{*reason, time(part(spec, "drain"), "since").value_or(0)};
  }
  worker.created = time(metadata, "creationTimestamp").value_or(0);
  worker.deleted = time(metadata, "deletionTimestamp");
  worker.finalizer = has_finalizer(metadata);
  const auto owned = owner(metadata, "RenderFleet");
  const Labels with = labels(part(metadata, "labels"));
  const auto label = with.find(kFleetLabel);
  worker.labelled = owned && owned->uid == worker.fleet_uid && label != with.end() &&
                    label->second == worker.fleet;
  worker.status.observed_generation = number<std::int64_t>(status, "observedGeneration", 0);
  worker.status.epoch = number<std::int64_t>(status, "epoch", 0);
  worker.status.failures = number(status, "failures", 0);
  worker.status.failed_pod = text(status, "failedPod");
  worker.status.failed_at = time(status, "failedAt").value_or(0);
  worker.status.conditions = conditions(status);
  const Json& pods = part(spec, "template");
  worker.gpus = std::max(gpus_of(part(pods, "spec")), 1);
  if (template_hash(pods) == worker.template_hash) {
    read.pods = templates.intern(worker.template_hash, pods);
  }
  return read;
}

std::optional<PodObject> read_pod(const Json& object, const std::string& home) {
  const Json& metadata = part(object, "metadata");
  const Json& spec = part(object, "spec");
  const Json& status = part(object, "status");
  PodObject read;
  Pod& pod = read.pod;
  read.name = kube::key_of(object, home);
  pod.name = text(metadata, "name");
  read.uid = pod.uid = text(metadata, "uid");
  read.version = pod.version = text(metadata, "resourceVersion");
  if (pod.name.empty()) return std::nullopt;
  const Labels with = labels(part(metadata, "labels"));
  const auto is = [&](const char* key, const std::string& value) {
    const auto found = with.find(key);
    return found != with.end() && (value.empty() || found->second == value);
  };
  const auto owned = owner(metadata, "RenderWorker");
  const bool at_home = read.name == pod.name;
  pod.owned = owned.has_value();
  pod.owner_uid = owned ? owned->uid : std::string();
  pod.labelled = owned && is(kFleetLabel, "") && is(kWorkerLabel, owned->name);
  const Json& annotations = part(metadata, "annotations");
  pod.epoch = std::strtoll(text(annotations, kEpochAnnotation, "0").c_str(), nullptr, 10);
  pod.phase = phase_of(text(status, "phase"));
  pod.node = text(spec, "nodeName");
  pod.gpus = gpus_of(spec);
  pod.created = time(metadata, "creationTimestamp").value_or(0);
  pod.terminating = time(metadata, "deletionTimestamp");
  for (const Condition& one : conditions(status)) {
    if (one.type == "Ready") pod.ready = one.status == ConditionStatus::kTrue;
    if (one.type == "PodScheduled" && one.status == ConditionStatus::kFalse &&
        one.reason == "Unschedulable") {
      pod.unschedulable = one.since;
    }
  }
  read.ours = at_home && (pod.owned || is(kFleetLabel, ""));
  const bool ended = pod.phase == Phase::kSucceeded || pod.phase == Phase::kFailed;
  read.gpus = pod.owned || ended || pod.node.empty() ? 0 : pod.gpus;
  // Other pods matter only if they use GPUs.
  if (!read.ours && read.gpus == 0) return std::nullopt;
  return read;
}

std::optional<NodeObject> read_node(const Json& object) {
  const Json& metadata = part(object, "metadata");
  const Json& spec = part(object, "spec");
  NodeObject read;
  Node& node = read.node;
  read.name = node.name = text(metadata, "name");
  read.uid = text(metadata, "uid");
  read.version = text(metadata, "resourceVersion");
  if (read.name.empty()) return std::nullopt;
  node.gpus = quantity(part(part(part(object, "status"), "allocatable"), kGpu));
  node.labels = labels(part(metadata, "labels"));
  const Json& cordoned = part(spec, "unschedulable");
  node.cordoned = cordoned.is_boolean() && cordoned.get<bool>();
  if (const Json& all = part(spec, "taints"); all.is_array()) {
    for (const Json& one : all) {
      node.taints.push_back({text(one, "key"), text(one, "value"), text(one, "effect")});
    }
  }
  node.ready = false;
  for (const Condition& one : conditions(part(object, "status"))) {
    if (one.type == "Ready") node.ready = one.status == ConditionStatus::kTrue;
  }
  return read;
}

Json& render_container(Json& pods) {
  Json& all = pods["spec"]["containers"];
  if (!all.is_array() || all.empty()) all = Json::array({{{"name", kContainer}}});
  for (Json& one : all) {
    if (text(one, "name") == kContainer) return one;
  }
  return all.front();
}

void set_environment(Json& container, const char* name, const std::string& value) {
  Json& all = container["env"];
  if (!all.is_array()) all = Json::array();
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const Json& one) { return text(one, "name") == name; }),
            all.end());
  all.insert(all.begin(), Json{{"name", name}, {"value", value}});
}

Json worker_template(Json pods, const FleetSpec& spec) {
  if (!pods.is_object() || !part(pods, "spec").is_object()) pods = {{"spec", Json::object()}};
  Json& container = render_container(pods);
  set_environment(container, "DIAPHANE_SLOTS", std::to_string(spec.sessions_per_worker));
  // The number is written only where the fleet or its template asks for several GPUs. Other
  // templates are the same as in versions that gave each worker one GPU, so that an upgrade does
  // not replace all workers.
  const bool requests_several = gpus_of(part(pods, "spec")) > 1;
  if (spec.gpus_per_worker > 1 || requests_several) set_gpus(container, spec.gpus_per_worker);
  return pods;
}

void set_gpus(Json& container, int gpus) {
  for (const char* kind : {"limits", "requests"}) {
    container["resources"][kind][kGpu] = std::to_string(gpus);
  }
}

std::string template_hash(const Json& pods) {
  // FNV-1a over the sorted keys, so that equal templates have equal hashes.
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char one : pods.dump()) {
    hash = (hash ^ static_cast<unsigned char>(one)) * 1099511628211ULL;
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::optional<Seconds> duration_of(const std::string& text) {
  Seconds sum = 0;
  const char* at = text.data();
  const char* const end = at + text.size();
  if (at == end) return std::nullopt;
  while (at != end) {
    double count = 0;
    const auto [rest, wrong] = std::from_chars(at, end, count);
    if (wrong != std::errc() || count < 0) return std::nullopt;
    const std::string_view unit(rest, static_cast<std::size_t>(end - rest));
    std::size_t letters = 1;
    if (unit.rfind("ms", 0) == 0) {
      sum += count / 1000;
      letters = 2;
    } else if (unit.rfind('h', 0) == 0) {
      sum += count * 3600;
    } else if (unit.rfind('m', 0) == 0) {
      sum += count * 60;
    } else if (unit.rfind('s', 0) == 0) {
      sum += count;
    } else {
      return std::nullopt;
    }
    at = rest + letters;
  }
  return sum;
}

}  // namespace diaphane::fleet
