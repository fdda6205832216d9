#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <unordered_map>

#include "operator/plan/cluster_state.h"

// Conversion of Kubernetes objects to the plan's data. Missing or malformed fields get their
// defaults, because the API server has validated what it stores and a single odd object must not
// stop anything.

namespace diaphane::fleet {

using Json = nlohmann::json;
using Template = std::shared_ptr<const Json>;

/// Returns whether an object with this metadata has this operator's finalizer.
bool has_finalizer(const Json& metadata);

struct FleetObject {
  std::string name, uid, version;
  Fleet fleet;
  Template pods;  ///< from worker_template()
  bool operator==(const FleetObject&) const = default;
};
struct WorkerObject {
  std::string name, uid, version;
  Worker worker;
  /// The template that the worker was created with, which its fleet may have replaced. Empty if it
  /// does not match its hash, because the API server does not check it and it may have been edited.
  Template pods;
  bool operator==(const WorkerObject&) const = default;
};
struct PodObject {
  std::string name, uid, version;
  Pod pod;
  bool ours = false;  ///< has Diaphane's label or is owned by a RenderWorker
  int gpus = 0;       ///< GPUs that it uses on `pod.node` if no RenderWorker owns it
  bool operator==(const PodObject&) const = default;
};
struct NodeObject {
  std::string name, uid, version;
  Node node;
  bool operator==(const NodeObject&) const = default;
};

/// Returns whether two objects differ only in their version.
bool equal_except_version(FleetObject a, const FleetObject& b);
bool equal_except_version(WorkerObject a, const WorkerObject& b);
bool equal_except_version(PodObject a, const PodObject& b);
bool equal_except_version(NodeObject a, const NodeObject& b);

/// Stores each template once, however many workers use it. Thread-safe.
class Templates {
 public:
  Template intern(const std::string& hash, const Json& pods);

 private:
  std::mutex mutex_;
  std::unordered_map<std::string, std::weak_ptr<const Json>> known_;
};

std::optional<FleetObject> read_fleet(const Json& object);
std::optional<WorkerObject> read_worker(const Json& object, Templates& templates);
std::optional<PodObject> read_pod(const Json& object, const std::string& home);
std::optional<NodeObject> read_node(const Json& object);

/// Returns the pod template with the number of slots and, if there are several, of GPUs, which
/// replaces a number in the template of the fleet. A worker is created with it, and its pod is
/// built only from it.
Json worker_template(Json pods, const FleetSpec& spec);
/// Sets the number of GPUs that a container requests.
void set_gpus(Json& container, int gpus);
/// Returns the hash of such a template. Workers with another hash are outdated.
std::string template_hash(const Json& pods);
/// Returns the container that renders: "renderd", or else the first one, which is created if there
/// is none.
Json& render_container(Json& pods);
/// Sets a variable at the front of the environment, so that other variables may refer to it.
void set_environment(Json& container, const char* name, const std::string& value);
/// Parses durations such as "90s", "1h30m" or "250ms". Returns nullopt for anything else.
std::optional<Seconds> duration_of(const std::string& text);

}  // namespace diaphane::fleet
