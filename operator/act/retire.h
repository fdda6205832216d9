#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "operator/act/objects.h"
#include "operator/kube/api.h"

// Deletes a fleet whose operator is uninstalled with it. A running operator drains it first. If
// that takes too long, or no operator runs, the finalizers are removed.

namespace diaphane::fleet {

/// Objects as they were read. The workers belong to the fleet.
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

/// Returns the next steps. If `in_time`, the operator may still drain the fleet. If there are no
/// steps but something is left, the caller waits.
std::vector<RetireStep> retire_steps(const Remains& left, bool in_time);

struct RetireOptions {
  std::string name_space;
  std::string fleet;
  Seconds grace = 0;
  std::function<Seconds()> clock;
  std::function<void()> pause;  ///< waits between two polls
};

/// Deletes the fleet, and returns when neither it nor any of its workers is left. Fails with
/// kForbidden or kUnauthenticated, which cannot recover, and retries all other errors.
Result<void> retire(kube::Api& api, const RetireOptions& options);

}  // namespace diaphane::fleet
