#include "operator/act/objects.h"

#include <algorithm>

#include "operator/kube/api.h"
#include "operator/names.h"
#include "operator/observe/objects.h"
#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

Json owned_by(const char* kind, const std::string& name, const std::string& uid) {
  return Json::array({{{"apiVersion", kVersion},
                       {"kind", kind},
                       {"name", name},
                       {"uid", uid},
                       {"controller", true},
                       {"blockOwnerDeletion", true}}});
}

Json labels_of(const std::string& fleet, const std::string& worker) {
  return {{kFleetLabel, fleet}, {kWorkerLabel, worker}};
}

Json metadata_of(const Target& target) {
  Json metadata = {{"name", target.name}, {"uid", target.uid}};
  if (!target.version.empty()) metadata["resourceVersion"] = target.version;
  return metadata;
}

Json patch_of(const char* kind, const Target& target) {
  const bool pod = std::string_view(kind) == "Pod";
  return {{"apiVersion", pod ? "v1" : kVersion}, {"kind", kind}, {"metadata", metadata_of(target)}};
}

Json conditions_of(const std::vector<Condition>& conditions, std::int64_t generation) {
  Json all = Json::array();
  for (const Condition& one : conditions) {
    all.push_back({{"type", one.type},
                   {"status", one.status == ConditionStatus::kTrue    ? "True"
                              : one.status == ConditionStatus::kFalse ? "False"
                                                                      : "Unknown"},
                   {"reason", one.reason.empty() ? one.type : one.reason},
                   {"message", one.message},
                   {"observedGeneration", generation},
                   {"lastTransitionTime", kube::time_text(one.since)}});
  }
  return all;
}

}  // namespace

Json worker_object(const CreateWorker& action, const Json& pods) {
  return {{"apiVersion", kVersion},
          {"kind", "RenderWorker"},
          {"metadata",
           {{"name", action.name},
            {"labels", labels_of(action.fleet, action.name)},
            {"finalizers", {kFinalizer}},
            {"ownerReferences", owned_by("RenderFleet", action.fleet, action.fleet_uid)}}},
          {"spec",
           {{"fleetName", action.fleet},
            {"fleetUid", action.fleet_uid},
            {"nodeName", action.node},
            {"templateHash", action.template_hash},
            {"template", pods}}}};
}

Json pod_object(const CreatePod& action, const std::string& fleet, const Labels& selector,
                Json pods) {
  Json metadata = pods.value("metadata", Json::object());
  if (!metadata["labels"].is_object()) metadata["labels"] = Json::object();
  metadata["name"] = action.worker;
  metadata["labels"].update(labels_of(fleet, action.worker));
  metadata["annotations"][kEpochAnnotation] = std::to_string(action.epoch);
  metadata["ownerReferences"] = owned_by("RenderWorker", action.worker, action.worker_uid);
  Json& container = render_container(pods);
  set_gpus(container, action.gpus);
  set_environment(container, "DIAPHANE_OWNER", owner_text(fleet, action.worker_uid, action.epoch));
  set_environment(container, "DIAPHANE_WORKER_ID", action.worker);
  Json& spec = pods["spec"];
  // Node affinity leaves the binding to the scheduler, which rejects pods that do not fit.
  const Json node_term = {
      {"matchFields", {{{"key", "metadata.name"}, {"operator", "In"}, {"values", {action.node}}}}}};
  spec["affinity"]["nodeAffinity"]["requiredDuringSchedulingIgnoredDuringExecution"] = {
      {"nodeSelectorTerms", {node_term}}};
  for (const auto& [key, value] : selector) spec["nodeSelector"][key] = value;
  return {{"apiVersion", "v1"}, {"kind", "Pod"}, {"metadata", metadata}, {"spec", spec}};
}

Json finalizer_patch(Kind kind, const Target& target) {
  Json patch = patch_of(kind == Kind::kFleet ? "RenderFleet" : "RenderWorker", target);
  patch["metadata"]["finalizers"] = {kFinalizer};
  return patch;
}

Json worker_patch(const Target& target, const Worker& worker) {
  Json patch = finalizer_patch(Kind::kWorker, target);
  patch["metadata"]["labels"] = labels_of(worker.fleet, worker.name);
  patch["metadata"]["ownerReferences"] = owned_by("RenderFleet", worker.fleet, worker.fleet_uid);
  return patch;
}

Json pod_patch(const Target& target, const std::string& fleet, const std::string& worker) {
  Json patch = patch_of("Pod", target);
  patch["metadata"]["labels"] = labels_of(fleet, worker);
  return patch;
}

Json drain_patch(const Target& target, const Drain& drain) {
  Json patch = patch_of("RenderWorker", target);
  patch["spec"]["drain"] = {{"reason", to_string(drain.reason)},
                            {"since", kube::time_text(drain.since)}};
  return patch;
}

Json worker_status_patch(const Target& target, const WorkerStatus& status) {
  Json patch = patch_of("RenderWorker", target);
  Json& out = patch["status"];
  out = {{"observedGeneration", status.observed_generation},
         {"epoch", status.epoch},
         {"failures", status.failures},
         {"conditions", conditions_of(status.conditions, status.observed_generation)}};
  if (!status.failed_pod.empty()) {
    out["failedPod"] = status.failed_pod;
    out["failedAt"] = kube::time_text(status.failed_at);
  }
  return patch;
}

Json fleet_status_patch(const Target& target, const FleetStatus& status) {
  Json patch = patch_of("RenderFleet", target);
  Json refusals = Json::array();
  for (const NodeBackoff& one : status.refusals) {
    refusals.push_back(
        {{"node", one.node}, {"count", one.count}, {"since", kube::time_text(one.since)}});
  }
  patch["status"] = {{"observedGeneration", status.observed_generation},
                     {"replicas", status.replicas},
                     {"readyReplicas", status.ready_replicas},
                     {"slotsTotal", status.slots_total},
                     {"slotsUsed", status.slots_used},
                     {"slotsReserved", status.slots_reserved},
                     {"selector", std::string(kFleetLabel) + "=" + target.name},
                     {"refusals", refusals},
                     {"conditions", conditions_of(status.conditions, status.observed_generation)},
                     {"written", kube::time_text(status.written)}};
  return patch;
}

const char* collection(Kind kind) {
  switch (kind) {
    case Kind::kFleet:
      return "renderfleets";
    case Kind::kWorker:
      return "renderworkers";
    case Kind::kPod:
      return "pods";
  }
  return "pods";
}

std::string path_of(const std::string& name_space, Kind kind, const std::string& name) {
  std::string path = kind == Kind::kPod ? "/api/v1" : std::string("/apis/") + kVersion;
  path += "/namespaces/" + name_space + "/" + collection(kind);
  return name.empty() ? path : path + "/" + name;
}

Json without_finalizer(Json object) {
  Json& all = object["metadata"]["finalizers"];
  if (all.is_array()) all.erase(std::remove(all.begin(), all.end(), kFinalizer), all.end());
  object["metadata"].erase("managedFields");
  return object;
}

}  // namespace diaphane::fleet
