#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <unordered_map>

#include "operator/plan/world.h"

// Objects of the Kubernetes API as the plan knows them. What is missing or odd in one is left at
// its default: the API server has checked what it stored, and one strange object stops nothing.

namespace diaphane::fleet {

using Json = nlohmann::json;
using Template = std::shared_ptr<const Json>;

/// Whether an object of this metadata waits for us before it goes.
bool has_finalizer(const Json& metadata);

struct FleetObject {
  std::string name, uid, version;
  Fleet fleet;
  Template pods;  ///< with_slots
  bool operator==(const FleetObject&) const = default;
};
struct WorkerObject {
  std::string name, uid, version;
  Worker worker;
  /// That it was made with: its fleet may have another by now. Nothing where it is not what its
  /// hash says: the API server does not look into it, and somebody may have changed it.
  Template pods;
  bool operator==(const WorkerObject&) const = default;
};
struct PodObject {
  std::string name, uid, version;
  Pod pod;
  bool ours = false;  ///< with our label, or owned by a RenderWorker
  int gpus = 0;       ///< that it holds on `pod.node`, when nobody of ours owns it
  bool operator==(const PodObject&) const = default;
};
struct NodeObject {
  std::string name, uid, version;
  Node node;
  bool operator==(const NodeObject&) const = default;
};

/// They differ in nothing but their version.
bool alike(FleetObject a, const FleetObject& b);
bool alike(WorkerObject a, const WorkerObject& b);
bool alike(PodObject a, const PodObject& b);
bool alike(NodeObject a, const NodeObject& b);

/// The same template is held once, however many workers were made with it. Thread-safe.
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

/// The template with the number of slots in it: what a worker is made with, and all that its pod is
/// made of.
Json with_slots(Json pods, int slots);
/// Of that: workers with another are outdated.
std::string template_hash(const Json& pods);
/// The container that renders: "renderd", else the first; one is made where there is none.
Json& render_container(Json& pods);
/// Its environment, with one more variable, first, so that others may refer to it.
void set_environment(Json& container, const char* name, const std::string& value);
/// "90s", "1h30m", "250ms"; nothing for what is none.
std::optional<Seconds> duration_of(const std::string& text);

}  // namespace diaphane::fleet
