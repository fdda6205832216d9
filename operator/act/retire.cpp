#include "operator/act/retire.h"

#include "common/log.h"
#include "common/try.h"
#include "operator/kube/fields.h"
#include "operator/observe/objects.h"

namespace diaphane::fleet {
namespace {

using kube::part;
using kube::text;

void add_steps(std::vector<RetireStep>& steps, Kind kind, const Json& object,
               bool remove_finalizers) {
  // The finalizer is removed after deletion starts, because a running operator would restore it
  // before.
  if (text(part(object, "metadata"), "deletionTimestamp").empty()) {
    steps.push_back({RetireStep::What::kDelete, kind, object});
  } else if (remove_finalizers && has_finalizer(part(object, "metadata"))) {
    steps.push_back({RetireStep::What::kLetGo, kind, object});
  }
}

Result<Remains> find_remains(kube::Api& api, const RetireOptions& options, bool in_time) {
  Remains left;
  auto fleet = api.get(path_of(options.name_space, Kind::kFleet, options.fleet));
  if (fleet) {
    left.fleet = std::move(*fleet);
  } else if (fleet.error().code != ErrorCode::kNotFound) {
    return tl::unexpected(fleet.error());
  }
  // There may be thousands of workers, so they are read only when something will be done about
  // them.
  if (left.fleet && in_time) return left;
  auto list = api.get(path_of(options.name_space, Kind::kWorker));
  DIAPHANE_TRY(list);
  for (const Json& worker : part(*list, "items")) {
    if (text(part(worker, "spec"), "fleetName") == options.fleet) left.workers.push_back(worker);
  }
  return left;
}

Result<void> carry_out(kube::Api& api, const RetireOptions& options, const RetireStep& step) {
  const Json& metadata = part(step.object, "metadata");
  const std::string path = path_of(options.name_space, step.kind, text(metadata, "name"));
  if (step.what == RetireStep::What::kDelete) {
    return api.remove(path, {text(metadata, "uid"), {}});
  }
  const auto answer = api.replace(path, without_finalizer(step.object));
  DIAPHANE_TRY(answer);
  return {};
}

bool never(const Error& error) {
  return error.code == ErrorCode::kForbidden || error.code == ErrorCode::kUnauthenticated;
}

}  // namespace

std::vector<RetireStep> retire_steps(const Remains& left, bool in_time) {
  std::vector<RetireStep> steps;
  if (!in_time) {
    for (const Json& worker : left.workers) add_steps(steps, Kind::kWorker, worker, true);
  }
  // The fleet is deleted last, because its workers are found by its name.
  if (left.fleet) add_steps(steps, Kind::kFleet, *left.fleet, !in_time && left.workers.empty());
  return steps;
}

Result<void> retire(kube::Api& api, const RetireOptions& options) {
  const Seconds begun = options.clock();
  bool announced = false;
  for (;; options.pause()) {
    const bool in_time = options.clock() - begun < options.grace;
    const auto left = find_remains(api, options, in_time);
    if (!left && never(left.error())) return tl::unexpected(left.error());
    if (!left) {
      log::warning("read_failed", {{"message", left.error().message}});
      continue;
    }
    if (!left->fleet && left->workers.empty()) return {};
    if (!in_time && !announced) {
      announced = true;
      log::warning("finalizers_removed",
                   {{"workers", static_cast<std::int64_t>(left->workers.size())}});
    }
    for (const RetireStep& step : retire_steps(*left, in_time)) {
      const auto done = carry_out(api, options, step);
      if (!done && never(done.error())) return done;
      // A conflict or a missing object is resolved at the next poll.
    }
  }
}

}  // namespace diaphane::fleet
