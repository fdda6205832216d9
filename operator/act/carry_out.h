#pragma once

#include <functional>

#include "operator/act/events.h"
#include "operator/observe/snapshot.h"
#include "operator/plan/plan.h"

namespace diaphane::fleet {

/// The object that an action is about ("worker/skull-3"): actions on one are carried out one after
/// the other.
std::string key_of(const Action& action);
/// As metrics and logs call it.
const char* name_of(const Action& action);

/// Sends actions to the API server. Thread-safe.
class Carrier {
 public:
  struct Options {
    std::string name_space;
    /// What the API server answered to a write, before the watch tells it.
    std::function<void(Kind, const Json&)> wrote;
  };
  Carrier(Options options, kube::Api& api, Events& events)
      : options_(std::move(options)), api_(api), events_(events) {}

  /// Those of one object, in their order; ends with the first that fails. kConflict: it changed
  /// since, or is there already: what there is was read again.
  Result<void> carry_out(const std::vector<const Action*>& actions, const Snapshot& seen);

 private:
  struct Turn;  ///< of one object: its version moves on with each write
  Result<void> one(const CreateWorker& action, Turn& turn);
  Result<void> one(const CreatePod& action, Turn& turn);
  Result<void> one(const SetDrain& action, Turn& turn);
  Result<void> one(const DeletePod& action, Turn& turn);
  Result<void> one(const DeleteWorker& action, Turn& turn);
  Result<void> one(const RemoveFinalizer& action, Turn& turn);
  Result<void> one(const Restore& action, Turn& turn);
  Result<void> one(const SetWorkerStatus& action, Turn& turn);
  Result<void> one(const SetFleetStatus& action, Turn& turn);

  std::string path(Kind kind, const std::string& name = "", const char* part = "") const;
  Result<void> wrote(Kind kind, const Result<Json>& answer, Turn& turn);
  Result<void> created(Kind kind, const std::string& name, const Result<Json>& answer, Turn& turn);
  static Result<void> gone(const Result<void>& answer);

  const Options options_;
  kube::Api& api_;
  Events& events_;
};

}  // namespace diaphane::fleet
