#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "operator/act/objects.h"
#include "operator/kube/api.h"

// The end of a fleet whose operator goes with it: deleted while an operator is there to drain it,
// and let go of when that takes too long or nobody is there.

namespace diaphane::fleet {

/// As they were read; workers are those of that fleet.
struct Remains {
  std::optional<Json> fleet;
  std::vector<Json> workers;
};

struct RetireStep {
  enum class What { kDelete, kLetGo };
  What what = What::kDelete;
  Kind kind = Kind::kFleet;
  Json object;
};

/// What is done now. `in_time`: the operator may still drain them. Nothing to do, and something
/// left: it is waited for.
std::vector<RetireStep> retire_steps(const Remains& left, bool in_time);

struct RetireOptions {
  std::string name_space;
  std::string fleet;
  Seconds grace = 0;
  std::function<Seconds()> clock;
  std::function<void()> pause;  ///< between two looks
};

/// Returns when neither the fleet nor a worker of it is left. kForbidden, kUnauthenticated: it
/// never will be; whatever else fails is tried again.
Result<void> retire(kube::Api& api, const RetireOptions& options);

}  // namespace diaphane::fleet
