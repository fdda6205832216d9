#include "operator/kube/leader.h"

#include "common/log.h"
#include "operator/kube/fields.h"
#include "operator/kube/informer.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

double wall() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

json lease_object(const std::string& name, const LeaseRecord& record) {
  json object = {{"apiVersion", "coordination.k8s.io/v1"},
                 {"kind", "Lease"},
                 {"metadata", {{"name", name}}},
                 {"spec",
                  {{"holderIdentity", record.holder},
                   {"leaseDurationSeconds", record.duration.count()},
                   {"acquireTime", record.acquired},
                   {"renewTime", record.renewed},
                   {"leaseTransitions", record.transitions}}}};
  if (!record.version.empty()) object["metadata"]["resourceVersion"] = record.version;
  return object;
}

LeaseRecord lease_record(const json& object) {
  LeaseRecord record;
  record.version = version_of(object);
  const json& spec = part(object, "spec");
  record.holder = text(spec, "holderIdentity");
  record.duration = std::chrono::seconds(number(spec, "leaseDurationSeconds", 15));
  record.transitions = number(spec, "leaseTransitions", 0);
  record.acquired = text(spec, "acquireTime");
  record.renewed = text(spec, "renewTime");
  return record;
}

Leader::Leader(Options options, Api& api)
    : options_(std::move(options)),
      api_(api),
      decision_(options_.lease),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Leader::~Leader() {
  thread_ = {};
  if (leads()) give_back();
}

bool Leader::leads() const {
  const std::lock_guard lock(mutex_);
  return decision_.leads(steady_clock::now());
}

void Leader::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    LeaseDecision::Step step = decision_.step(steady_clock::now());
    const bool led = decision_.has_led();
    if (step == LeaseDecision::Step::kLost) {
      log::error("lease_lost");
      lock.unlock();
      return options_.lost();
    }
    lock.unlock();
    if (!led) poll();
    lock.lock();
    step = decision_.step(steady_clock::now());
    lock.unlock();
    if (step == LeaseDecision::Step::kCreate || step == LeaseDecision::Step::kAcquire ||
        step == LeaseDecision::Step::kRenew) {
      write(led);
    }
    lock.lock();
    const double random = std::uniform_real_distribution<double>(0, 1)(random_);
    wake_.wait_for(lock, stop, decision_.pause(random), [] { return false; });
  }
}

void Leader::poll() {
  const auto read = api_.get(options_.path + "/" + options_.name);
  const std::lock_guard lock(mutex_);
  if (read) {
    decision_.observed(lease_record(*read), steady_clock::now());
  } else if (read.error().code == ErrorCode::kNotFound) {
    decision_.observed(std::nullopt, steady_clock::now());
  } else {
    log::warning("lease_read_failed", {{"message", read.error().message}});
  }
}

void Leader::write(bool held) {
  LeaseRecord record;
  bool create = false;
  {
    const std::lock_guard lock(mutex_);
    create = !decision_.record();
    if (!create) record = *decision_.record();
  }
  const std::string now = kube::time_text(wall());
  if (!held) {
    record.acquired = now;
    if (!create && record.holder != options_.lease.identity) ++record.transitions;
  }
  record.holder = options_.lease.identity;
  record.duration = options_.lease.duration;
  record.renewed = now;
  const json object = lease_object(options_.name, record);
  const auto begun = steady_clock::now();
  const auto written = create ? api_.create(options_.path, object)
                              : api_.replace(options_.path + "/" + options_.name, object);
  if (written) {
    {
      const std::lock_guard lock(mutex_);
      decision_.written(lease_record(*written), begun);
    }
    if (!held) {
      log::info("lease_acquired", {{"identity", options_.lease.identity}});
      options_.won();
    }
    return;
  }
  log::warning("lease_write_failed", {{"message", written.error().message}});
  // Another process changed the lease, or the result is unknown, so it is read again.
  if (held) poll();
}

void Leader::give_back() {
  LeaseRecord record;
  {
    const std::lock_guard lock(mutex_);
    if (!decision_.record()) return;
    record = *decision_.record();
  }
  record.holder.clear();
  record.duration = std::chrono::seconds(1);
  record.renewed = kube::time_text(wall());
  if (api_.replace(options_.path + "/" + options_.name, lease_object(options_.name, record))) {
    log::info("lease_released");
  }
}

}  // namespace diaphane::kube
