#pragma once

#include <nlohmann/json.hpp>

#include "operator/plan/plan.h"

// What is sent to the API server for an action: pure.

namespace diaphane::fleet {

using Json = nlohmann::json;

/// What server-side apply and an own write have to name of an object.
struct Target {
  std::string name, uid, version;
};

Json worker_object(const CreateWorker& action, const Json& pods);
/// `pods`: with_slots. `selector`: of the fleet, beside the node.
Json pod_object(const CreatePod& action, const std::string& fleet, const Labels& selector,
                Json pods);

/// Applied, each by its own part of the field manager's name: what one does not name it does not
/// take away from another.
Json finalizer_patch(Kind kind, const Target& target);
Json worker_patch(const Target& target, const Worker& worker);
Json pod_patch(const Target& target, const std::string& fleet, const std::string& worker);
Json drain_patch(const Target& target, const Drain& drain);
Json worker_status_patch(const Target& target, const WorkerStatus& status);
Json fleet_status_patch(const Target& target, const FleetStatus& status);

/// "renderfleets"
const char* collection(Kind kind);
/// At the API server; without a name of the whole collection.
std::string path_of(const std::string& name_space, Kind kind, const std::string& name = {});

/// The object as it was read, without our finalizer.
Json without_finalizer(Json object);

}  // namespace diaphane::fleet
