#pragma once

#include <nlohmann/json.hpp>

#include "operator/plan/plan.h"

// Pure functions that build the objects sent to the API server for an action.

namespace diaphane::fleet {

using Json = nlohmann::json;

/// Identifies an object in server-side apply and in conditional writes.
struct Target {
  std::string name, uid, version;
};

Json worker_object(const CreateWorker& action, const Json& pods);
/// `pods` comes from worker_template(). `selector` is the fleet's node selector, to which the node
/// is added.
Json pod_object(const CreatePod& action, const std::string& fleet, const Labels& selector,
                Json pods);

/// Objects for server-side apply, each with its own part of the field manager's name, so that one
/// patch does not remove the fields of another.
Json finalizer_patch(Kind kind, const Target& target);
Json worker_patch(const Target& target, const Worker& worker);
Json pod_patch(const Target& target, const std::string& fleet, const std::string& worker);
Json drain_patch(const Target& target, const Drain& drain);
Json worker_status_patch(const Target& target, const WorkerStatus& status);
Json fleet_status_patch(const Target& target, const FleetStatus& status);

/// Returns the plural of a kind, for example "renderfleets".
const char* collection(Kind kind);
/// Returns the path of an object at the API server, or of the whole collection without a name.
std::string path_of(const std::string& name_space, Kind kind, const std::string& name = {});

/// Returns the object without this operator's finalizer.
Json without_finalizer(Json object);

}  // namespace diaphane::fleet
