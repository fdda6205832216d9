#pragma once

#include <functional>

#include "operator/act/events.h"
#include "operator/observe/snapshot.h"
#include "operator/plan/plan.h"

namespace diaphane::fleet {

/// Returns the key of the object that an action concerns ("worker/skull-3"). Actions on one object
/// are executed in sequence.
std::string key_of(const Action& action);
/// Returns the name of an action in metrics and logs.
const char* name_of(const Action& action);

/// Sends actions to the API server. Thread-safe.
class Carrier {
 public:
  struct Options {
    std::string name_space;
    /// Receives the API server's answer to a write before the watch reports it.
    std::function<void(Kind, const Json&)> wrote;
  };
  Carrier(Options options, kube::Api& api, Events& events)
      : options_(std::move(options)), api_(api), events_(events) {}

  /// Executes the actions on one object in order, up to the first failure. kConflict: the object
  /// changed or already exists, and its current state was read.
  Result<void> carry_out(const std::vector<const Action*>& actions, const Snapshot& seen);

 private:
  struct Turn;  ///< state of one object, whose version advances with each write
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
