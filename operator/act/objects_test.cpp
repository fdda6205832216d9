#include "operator/act/objects.h"

#include <gtest/gtest.h>

#include "operator/observe/objects.h"

namespace diaphane::fleet {
namespace {

Json pods() {
  return Json::parse(R"({"metadata": {"labels": {"app": "renderd"}, "annotations": {"note": "x"}},
    "spec": {"tolerations": [{"key": "gpu", "operator": "Exists", "effect": "NoSchedule"}],
             "containers": [{"name": "sidecar", "image": "s"},
                            {"name": "renderd", "image": "r", "resources": {"limits": {"memory": "1Gi"}},
                             "env": [{"name": "DIAPHANE_SLOTS", "value": "9"}, {"name": "X", "value": "y"}]}]}})");
}

Json fleet_object() {
  return {{"metadata",
           {{"name", "skull"},
            {"uid", "f"},
            {"resourceVersion", "7"},
            {"generation", 3},
            {"finalizers", {"diaphane.dev/drain"}}}},
          {"spec",
           {{"sessionsPerWorker", 4},
            {"strategy", "Packed"},
            {"warm", {{"minIdleSlots", 2}, {"maxRefillPerSecond", 0.5}}},
            {"scaleToZeroAfter", "1h30m"},
            {"drainTimeout", "90s"},
            {"replicas", 2},
            {"nodeSelector", {{"pool", "gpu"}}},
            {"template", pods()}}}};
}

const std::string kHash = template_hash(pods());
const CreateWorker kWorker{"skull-0", "skull", "f", "node-1", kHash};
const CreatePod kPod{"skull-0", "w", "node-1", kHash, 3};

TEST(Objects, ParsesFleet) {
  const auto read = read_fleet(fleet_object());
  ASSERT_TRUE(read);
  const FleetSpec& spec = read->fleet.spec;
  EXPECT_EQ(spec.sessions_per_worker, 4);
  EXPECT_EQ(spec.strategy, Strategy::kPacked);
  EXPECT_EQ(spec.min_idle_slots, 2);
  EXPECT_EQ(spec.max_refill_per_second, 0.5);
  EXPECT_EQ(spec.scale_to_zero_after, 5400);
  EXPECT_EQ(spec.drain_timeout, 90);
  EXPECT_EQ(spec.replicas, 2);
  EXPECT_EQ(spec.node_selector.at("pool"), "gpu");
  ASSERT_EQ(spec.tolerations.size(), 1U);
  EXPECT_EQ(spec.tolerations[0].effect, "NoSchedule");
  EXPECT_TRUE(read->fleet.finalizer);
  EXPECT_FALSE(read->fleet.deleted);
}

TEST(Objects, TemplateHashDependsOnlyOnItsContent) {
  const FleetSpec spec{.sessions_per_worker = 4};
  const std::string hash = template_hash(worker_template(pods(), spec));
  EXPECT_EQ(template_hash(worker_template(Json::parse(pods().dump()), spec)), hash);
  EXPECT_NE(template_hash(worker_template(pods(), {.sessions_per_worker = 5})), hash);
  Json other = pods();
  other["spec"]["containers"][1]["image"] = "r2";
  EXPECT_NE(template_hash(worker_template(other, spec)), hash);
  EXPECT_EQ(read_fleet(fleet_object())->fleet.spec.template_hash, hash);
}

TEST(Objects, WorkerRoundTrips) {
  Json object = worker_object(kWorker, pods());
  object["metadata"]["uid"] = "w";
  object["metadata"]["resourceVersion"] = "9";
  Templates templates;
  const auto read = read_worker(object, templates);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->worker.fleet, "skull");
  EXPECT_EQ(read->worker.fleet_uid, "f");
  EXPECT_EQ(read->worker.node, "node-1");
  EXPECT_EQ(read->worker.template_hash, kHash);
  EXPECT_TRUE(read->worker.labelled);
  EXPECT_TRUE(read->worker.finalizer);
  ASSERT_TRUE(read->pods);
  EXPECT_EQ(*read->pods, pods());
  Json changed = object;
  changed["spec"]["template"]["spec"]["containers"][1]["image"] = "another";
  EXPECT_FALSE(read_worker(changed, templates)->pods);
  object["metadata"]["labels"].erase("diaphane.dev/fleet");
  EXPECT_FALSE(read_worker(object, templates)->worker.labelled);
}

TEST(Objects, WorkerStatusRoundTrips) {
  WorkerStatus status;
  status.observed_generation = 2;
  status.epoch = 5;
  status.failures = 1;
  status.failed_pod = "p";
  status.failed_at = 1795359845.25;
  status.conditions = {{"Ready", ConditionStatus::kFalse, "Starting", "", 1795359840.5},
                       {"Scheduled", ConditionStatus::kUnknown, "NoPod", "", 1795359841}};
  Json object = worker_object(kWorker, pods());
  object["status"] = worker_status_patch({"skull-0", "w", "9"}, status)["status"];
  object["spec"]["drain"] =
      drain_patch({"skull-0", "w", "9"}, {DrainReason::kIdle, 1795359850.125})["spec"]["drain"];
  Templates templates;
  const auto read = read_worker(object, templates);
  EXPECT_EQ(read->worker.status, status);
  EXPECT_EQ(read->worker.drain, (Drain{DrainReason::kIdle, 1795359850.125}));
}

TEST(Objects, FleetStatusRoundTrips) {
  FleetStatus status;
  status.replicas = 3;
  status.slots_reserved = 1;
  status.written = 1795359845.75;
  status.refusals = {{"node-1", 2, 1795359840.25}};
  status.conditions = {{"Available", ConditionStatus::kTrue, "Ready", "3 of 3", 1795359840}};
  Json object = fleet_object();
  object["status"] = fleet_status_patch({"skull", "f", "7"}, status)["status"];
  const FleetStatus read = read_fleet(object)->fleet.status;
  EXPECT_EQ(read.replicas, 3);
  EXPECT_EQ(read.slots_reserved, 1);
  EXPECT_EQ(read.written, status.written);
  EXPECT_EQ(read.refusals, status.refusals);
  EXPECT_EQ(read.conditions, status.conditions);
  EXPECT_EQ(object["status"]["selector"], "diaphane.dev/fleet=skull");
}

TEST(Objects, PodRequestsItsGpuNodeAndName) {
  const Json pod = pod_object(kPod, "skull", {{"pool", "gpu"}},
                              worker_template(pods(), {.sessions_per_worker = 4}));
  const Json& container = pod["spec"]["containers"][1];
  EXPECT_EQ(container["resources"]["limits"]["nvidia.com/gpu"], "1");
  EXPECT_EQ(container["resources"]["limits"]["memory"], "1Gi");
  EXPECT_EQ(container["env"].size(), 4U);
  EXPECT_EQ(container["env"][0], Json({{"name", "DIAPHANE_WORKER_ID"}, {"value", "skull-0"}}));
  EXPECT_EQ(container["env"][1]["value"], "skull/w/3");
  EXPECT_EQ(container["env"][2], Json({{"name", "DIAPHANE_SLOTS"}, {"value", "4"}}));
  EXPECT_EQ(container["env"][3]["name"], "X");
  EXPECT_FALSE(pod["spec"]["containers"][0].contains("resources"));
  const Json& term = pod["spec"]["affinity"]["nodeAffinity"]
                        ["requiredDuringSchedulingIgnoredDuringExecution"]["nodeSelectorTerms"];
  ASSERT_EQ(term.size(), 1U);
  EXPECT_EQ(term[0]["matchFields"][0]["key"], "metadata.name");
  EXPECT_EQ(term[0]["matchFields"][0]["values"], Json::array({"node-1"}));
  EXPECT_EQ(pod["spec"]["nodeSelector"]["pool"], "gpu");
  EXPECT_EQ(pod["metadata"]["labels"]["app"], "renderd");
}

TEST(Objects, PodRequestsAllGpusOfItsWorker) {
  Json fleet = fleet_object();
  fleet["spec"]["gpusPerWorker"] = 4;
  const auto read = read_fleet(fleet);
  EXPECT_EQ(read->fleet.spec.gpus_per_worker, 4);
  EXPECT_NE(read->fleet.spec.template_hash, read_fleet(fleet_object())->fleet.spec.template_hash)
      << "workers with another number of GPUs are outdated";
  CreateWorker create = kWorker;
  create.template_hash = read->fleet.spec.template_hash;
  Templates templates;
  const auto worker = read_worker(worker_object(create, *read->pods), templates);
  EXPECT_EQ(worker->worker.gpus, 4);
  CreatePod action = kPod;
  action.gpus = worker->worker.gpus;
  Json pod = pod_object(action, "skull", {}, *worker->pods);
  EXPECT_EQ(pod["spec"]["containers"][1]["resources"]["limits"]["nvidia.com/gpu"], "4");
  pod["metadata"]["uid"] = "p";
  EXPECT_EQ(read_pod(pod, "")->pod.gpus, 4);
  EXPECT_EQ(read_worker(worker_object(kWorker, pods()), templates)->worker.gpus, 1);
  Json& other = fleet["spec"]["template"]["spec"]["containers"][1]["resources"];
  other["limits"]["nvidia.com/gpu"] = "2";
  fleet["spec"]["gpusPerWorker"] = 1;
  EXPECT_EQ(read_worker(worker_object(kWorker, *read_fleet(fleet)->pods), templates)->worker.gpus,
            1)
      << "the template does not choose the number of GPUs";
}

TEST(Objects, PodIsOwnOnlyIfARenderWorkerOwnsIt) {
  Json object = pod_object(kPod, "skull", {}, pods());
  object["metadata"]["uid"] = "p";
  object["metadata"]["namespace"] = "home";
  auto read = read_pod(object, "home");
  ASSERT_TRUE(read && read->ours);
  EXPECT_TRUE(read->pod.owned);
  EXPECT_TRUE(read->pod.labelled);
  EXPECT_EQ(read->pod.owner_uid, "w");
  EXPECT_EQ(read->pod.epoch, 3);
  EXPECT_EQ(read->gpus, 0);

  // A foreign pod with Diaphane's label is observed but never owned, and its GPU is in use.
  object["metadata"].erase("ownerReferences");
  object["spec"]["nodeName"] = "node-1";
  read = read_pod(object, "home");
  ASSERT_TRUE(read && read->ours);
  EXPECT_FALSE(read->pod.owned);
  EXPECT_EQ(read->gpus, 1);

  // A kind of that name in another API group does not make the pod owned.
  object["metadata"]["ownerReferences"] = {{{"apiVersion", "other.dev/v1"},
                                            {"kind", "RenderWorker"},
                                            {"controller", true},
                                            {"uid", "w"}}};
  EXPECT_FALSE(read_pod(object, "home")->pod.owned);

  object["metadata"]["namespace"] = "elsewhere";
  read = read_pod(object, "home");
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->ours);
  EXPECT_EQ(read->name, "elsewhere/skull-0");
  EXPECT_EQ(read->gpus, 1);
  object["status"]["phase"] = "Succeeded";
  EXPECT_FALSE(read_pod(object, "home"));
}

TEST(Objects, ParsesPodState) {
  Json object = pod_object(kPod, "skull", {}, pods());
  object["status"] = Json::parse(R"({"phase": "Pending", "conditions": [
    {"type": "PodScheduled", "status": "False", "reason": "Unschedulable",
     "lastTransitionTime": "2026-11-22T15:04:05Z"}]})");
  EXPECT_EQ(read_pod(object, "")->pod.unschedulable, 1795359845);
  object["status"] =
      Json::parse(R"({"phase": "Running", "conditions": [{"type": "Ready", "status": "True"}]})");
  EXPECT_TRUE(read_pod(object, "")->pod.ready);
  EXPECT_EQ(read_pod(object, "")->pod.phase, Phase::kRunning);
}

TEST(Objects, ParsesNode) {
  const auto read = read_node(Json::parse(R"({"metadata": {"name": "n", "labels": {"pool": "gpu"}},
    "spec": {"unschedulable": true, "taints": [{"key": "k", "value": "v", "effect": "NoExecute"}]},
    "status": {"allocatable": {"nvidia.com/gpu": "8"}, "conditions": [{"type": "Ready", "status": "True"}]}})"));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->node.gpus, 8);
  EXPECT_TRUE(read->node.cordoned);
  EXPECT_TRUE(read->node.ready);
  EXPECT_EQ(read->node.taints[0].effect, "NoExecute");
}

TEST(Objects, ToleratesMalformedObjects) {
  Templates templates;
  for (const char* text :
       {"{}", R"({"metadata": 3, "spec": [], "status": "x"})",
        R"({"metadata": {"name": "a", "labels": 1, "ownerReferences": [7], "finalizers": "x"},
            "spec": {"drain": 1, "template": 2, "containers": 3, "taints": {}, "replicas": "x"},
            "status": {"conditions": [1, {}], "allocatable": {"nvidia.com/gpu": "many"}}})"}) {
    const Json object = Json::parse(text);
    EXPECT_NO_THROW({
      read_fleet(object);
      read_worker(object, templates);
      read_pod(object, "");
      read_node(object);
    }) << text;
  }
}

TEST(Objects, KeepsForeignFinalizers) {
  const Json object = {{"metadata", {{"finalizers", {"other/one", "diaphane.dev/drain"}}}}};
  EXPECT_EQ(without_finalizer(object)["metadata"]["finalizers"], Json::array({"other/one"}));
}

TEST(Durations, ParsesGoDurations) {
  EXPECT_EQ(duration_of("90s"), 90);
  EXPECT_EQ(duration_of("1h30m"), 5400);
  EXPECT_EQ(duration_of("1m250ms"), 60.25);
  for (const char* wrong : {"", "5", "s", "-5s", "5 s", "1d", "5sx"}) {
    EXPECT_FALSE(duration_of(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace diaphane::fleet
