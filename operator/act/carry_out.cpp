#include "operator/act/carry_out.h"

#include <algorithm>

#include "common/log.h"
#include "common/try.h"
#include "operator/act/objects.h"
#include "operator/kube/informer.h"
#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

const char* kind_name(Kind kind) {
  switch (kind) {
    case Kind::kFleet:
      return "RenderFleet";
    case Kind::kWorker:
      return "RenderWorker";
    case Kind::kPod:
      return "Pod";
  }
  return "Pod";
}

std::string key(Kind kind, const std::string& name) {
  return std::string(collection(kind)) + "/" + name;
}

struct KeyOf {
  std::string operator()(const CreateWorker& a) const { return key(Kind::kWorker, a.name); }
  std::string operator()(const CreatePod& a) const { return key(Kind::kPod, a.worker); }
  std::string operator()(const SetDrain& a) const { return key(Kind::kWorker, a.worker); }
  std::string operator()(const DeletePod& a) const { return key(Kind::kPod, a.name); }
  std::string operator()(const DeleteWorker& a) const { return key(Kind::kWorker, a.name); }
  std::string operator()(const RemoveFinalizer& a) const { return key(a.kind, a.name); }
  std::string operator()(const Restore& a) const { return key(a.kind, a.name); }
  std::string operator()(const SetWorkerStatus& a) const { return key(Kind::kWorker, a.name); }
  std::string operator()(const SetFleetStatus& a) const { return key(Kind::kFleet, a.name); }
};

struct NameOf {
  const char* operator()(const CreateWorker&) const { return "create_worker"; }
  const char* operator()(const CreatePod&) const { return "create_pod"; }
  const char* operator()(const SetDrain&) const { return "set_drain"; }
  const char* operator()(const DeletePod&) const { return "delete_pod"; }
  const char* operator()(const DeleteWorker&) const { return "delete_worker"; }
  const char* operator()(const RemoveFinalizer&) const { return "remove_finalizer"; }
  const char* operator()(const Restore&) const { return "restore"; }
  const char* operator()(const SetWorkerStatus&) const { return "set_worker_status"; }
  const char* operator()(const SetFleetStatus&) const { return "set_fleet_status"; }
};

template <typename T>
const T* find(const std::vector<T>& all, const std::string& uid) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const T& one) { return one.uid == uid; });
  return found == all.end() ? nullptr : &*found;
}

tl::unexpected<Error> not_in_snapshot() {
  return fail(ErrorCode::kConflict, "the object no longer exists", "NotSeen");
}

}  // namespace

std::string key_of(const Action& action) { return std::visit(KeyOf{}, action); }
const char* name_of(const Action& action) { return std::visit(NameOf{}, action); }

struct ActionExecutor::ExecutionContext {
  const Snapshot& snapshot;
  std::string version;  ///< resourceVersion after the last write, or empty

  Target target(const std::string& name, const std::string& uid, const std::string& at) const {
    return {name, uid, version.empty() ? at : version};
  }
  const Worker* worker(const std::string& uid) const {
    const auto found = snapshot.index.find(uid);
    return found == snapshot.index.end()
               ? nullptr
               : &snapshot.world.workers[static_cast<std::size_t>(found->second)];
  }
};

Result<void> ActionExecutor::carry_out(const std::vector<const Action*>& actions,
                                       const Snapshot& snapshot) {
  ExecutionContext context{snapshot, {}};
  for (const Action* action : actions) {
    auto done = std::visit([&](const auto& what) { return execute(what, context); }, *action);
    if (!done) return done;
  }
  return {};
}

std::string ActionExecutor::path(Kind kind, const std::string& name, const char* part) const {
  return path_of(options_.name_space, kind, name) + part;
}

Result<void> ActionExecutor::on_write(Kind kind, const Result<Json>& answer,
                                      ExecutionContext& context) {
  DIAPHANE_TRY(answer);
  context.version = kube::version_of(*answer);
  options_.on_write(kind, *answer);
  return {};
}

Result<void> ActionExecutor::created(Kind kind, const std::string& name, const Result<Json>& answer,
                                     ExecutionContext& context) {
  if (!answer && answer.error().field == "AlreadyExists") {
    // Another operator created it, or this one did without receiving the answer. The existing
    // object decides.
    const auto current = api_.get(path(kind, name));
    if (current) {
      options_.on_write(kind, *current);
    } else {
      log::warning("read_failed",
                   {{"object", key(kind, name)}, {"message", current.error().message}});
    }
  }
  return on_write(kind, answer, context);
}

Result<void> ActionExecutor::gone(const Result<void>& answer) {
  if (!answer && answer.error().code != ErrorCode::kNotFound) return answer;
  return {};
}

Result<void> ActionExecutor::execute(const CreateWorker& action, ExecutionContext& context) {
  const auto pods = context.snapshot.pods_of.find(action.fleet_uid);
  if (pods == context.snapshot.pods_of.end()) return not_in_snapshot();
  auto done =
      created(Kind::kWorker, action.name,
              api_.create(path(Kind::kWorker), worker_object(action, *pods->second)), context);
  if (done) {
    events_.record({"RenderFleet", action.fleet, action.fleet_uid, "Placed",
                    "Placed worker " + action.name + " on node " + action.node});
  }
  return done;
}

Result<void> ActionExecutor::execute(const CreatePod& action, ExecutionContext& context) {
  const Worker* worker = context.worker(action.worker_uid);
  const Fleet* of = worker ? find(context.snapshot.world.fleets, worker->fleet_uid) : nullptr;
  if (!of) return not_in_snapshot();
  const auto template_of = [&](const std::string& uid) {
    const auto found = context.snapshot.pods_of.find(uid);
    return found == context.snapshot.pods_of.end() ? Template() : found->second;
  };
  Template pods = template_of(action.worker_uid);
  // The template on the worker was edited by hand, but its fleet may still have the original.
  if (!pods && of->spec.template_hash == action.template_hash) pods = template_of(of->uid);
  if (!pods) {
    events_.record({"RenderWorker", action.worker, action.worker_uid, "PodRefused",
                    "The pod template does not match its hash. Delete this worker, and the "
                    "operator creates a new one",
                    true});
    return fail(ErrorCode::kInvalid, "the pod template of the worker does not match its hash",
                "TemplateChanged");
  }
  auto done = created(
      Kind::kPod, action.worker,
      api_.create(path(Kind::kPod), pod_object(action, of->name, of->spec.node_selector, *pods)),
      context);
  if (!done && done.error().field != "AlreadyExists") {
    events_.record({"RenderWorker", action.worker, action.worker_uid, "PodRefused",
                    done.error().message, true});
  }
  return done;
}

Result<void> ActionExecutor::execute(const SetDrain& action, ExecutionContext& context) {
  const Target target = context.target(action.worker, action.uid, action.version);
  auto done = on_write(
      Kind::kWorker,
      api_.apply(path(Kind::kWorker, action.worker), drain_patch(target, action.drain), "drain"),
      context);
  if (done) {
    events_.record({"RenderWorker", action.worker, action.uid, "Draining",
                    "Draining, reason: " + std::string(to_string(action.drain.reason))});
  }
  return done;
}

Result<void> ActionExecutor::execute(const DeletePod& action, ExecutionContext& context) {
  const Pod* pod = find(context.snapshot.world.pods, action.uid);
  if (!pod || !pod->owned) return not_in_snapshot();
  return gone(api_.remove(path(Kind::kPod, action.name), {action.uid, pod->version}));
}

Result<void> ActionExecutor::execute(const DeleteWorker& action, ExecutionContext& context) {
  const Worker* worker = context.worker(action.uid);
  if (!worker) return not_in_snapshot();
  const Target target = context.target(action.name, action.uid, worker->version);
  return gone(api_.remove(path(Kind::kWorker, action.name), {target.uid, target.version}));
}

Result<void> ActionExecutor::execute(const RemoveFinalizer& action, ExecutionContext& context) {
  const auto current = api_.get(path(action.kind, action.name));
  if (!current && current.error().code == ErrorCode::kNotFound) return {};
  DIAPHANE_TRY(current);
  const Target target = context.target(action.name, action.uid, action.version);
  const std::string uid = current->value("/metadata/uid"_json_pointer, "");
  if (uid != target.uid || kube::version_of(*current) != target.version) {
    options_.on_write(action.kind, *current);
    return fail(ErrorCode::kConflict, "the object has changed since it was read", "Conflict");
  }
  const auto answer = api_.replace(path(action.kind, action.name), without_finalizer(*current));
  // Removing the last finalizer deletes the object.
  if (!answer) return gone(tl::unexpected(answer.error()));
  return {};
}

Result<void> ActionExecutor::execute(const Restore& action, ExecutionContext& context) {
  if (action.kind == Kind::kFleet) {
    const Fleet* fleet = find(context.snapshot.world.fleets, action.uid);
    if (!fleet) return not_in_snapshot();
    return on_write(action.kind,
                    api_.apply(path(action.kind, action.name),
                               finalizer_patch(action.kind, context.target(action.name, action.uid,
                                                                           fleet->version))),
                    context);
  }
  events_.record({kind_name(action.kind), action.name, action.uid, "Restored",
                  "Restored labels, owner or finalizer that someone had changed", true});
  if (action.kind == Kind::kPod) {
    const Pod* pod = find(context.snapshot.world.pods, action.uid);
    const Worker* worker = pod ? context.worker(pod->owner_uid) : nullptr;
    if (!worker) return not_in_snapshot();
    return on_write(action.kind,
                    api_.apply(path(action.kind, action.name),
                               pod_patch(context.target(action.name, action.uid, pod->version),
                                         worker->fleet, worker->name)),
                    context);
  }
  const Worker* worker = context.worker(action.uid);
  if (!worker) return not_in_snapshot();
  return on_write(
      action.kind,
      api_.apply(path(action.kind, action.name),
                 worker_patch(context.target(action.name, action.uid, worker->version), *worker)),
      context);
}

Result<void> ActionExecutor::execute(const SetWorkerStatus& action, ExecutionContext& context) {
  const Worker* worker = context.worker(action.uid);
  if (!worker) return not_in_snapshot();
  const Target target = context.target(action.name, action.uid, worker->version);
  return on_write(Kind::kWorker,
                  api_.apply(path(Kind::kWorker, action.name, "/status"),
                             worker_status_patch(target, action.status), "status"),
                  context);
}

Result<void> ActionExecutor::execute(const SetFleetStatus& action, ExecutionContext& context) {
  const Fleet* fleet = find(context.snapshot.world.fleets, action.uid);
  if (!fleet) return not_in_snapshot();
  const Target target = context.target(action.name, action.uid, fleet->version);
  return on_write(Kind::kFleet,
                  api_.apply(path(Kind::kFleet, action.name, "/status"),
                             fleet_status_patch(target, action.status), "status"),
                  context);
}

}  // namespace diaphane::fleet
