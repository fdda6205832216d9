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
class ActionExecutor {
 public:
  struct Options {
    std::string name_space;
    /// Receives the API server's answer to a write before the watch reports it.
    std::function<void(Kind, const Json&)> on_write;
  };
  ActionExecutor(Options options, kube::Api& api, Events& events)
      : options_(std::move(options)), api_(api), events_(events) {}

  /// Executes the actions on one object in order, up to the first failure. Returns kConflict if the
  /// object has changed, already exists or no longer exists, so that a new plan must decide.
  Result<void> carry_out(const std::vector<const Action*>& actions, const Snapshot& snapshot);

 private:
  struct ExecutionContext;  ///< state of one object, whose version advances with each write
  Result<void> execute(const CreateWorker& action, ExecutionContext& context);
  Result<void> execute(const CreatePod& action, ExecutionContext& context);
  Result<void> execute(const SetDrain& action, ExecutionContext& context);
  Result<void> execute(const DeletePod& action, ExecutionContext& context);
  Result<void> execute(const DeleteWorker& action, ExecutionContext& context);
  Result<void> execute(const RemoveFinalizer& action, ExecutionContext& context);
  Result<void> execute(const Restore& action, ExecutionContext& context);
  Result<void> execute(const SetWorkerStatus& action, ExecutionContext& context);
  Result<void> execute(const SetFleetStatus& action, ExecutionContext& context);

  std::string path(Kind kind, const std::string& name = "", const char* part = "") const;
  Result<void> on_write(Kind kind, const Result<Json>& answer, ExecutionContext& context);
  Result<void> created(Kind kind, const std::string& name, const Result<Json>& answer,
                       ExecutionContext& context);
  static Result<void> gone(const Result<void>& answer);

  const Options options_;
  kube::Api& api_;
  Events& events_;
};

}  // namespace diaphane::fleet
