#include "operator/act/events.h"

#include "common/ids.h"
#include "common/log.h"
#include "operator/names.h"

namespace diaphane::fleet {
namespace {

constexpr std::size_t kMostWaiting = 256;

double wall() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Formats the time of an Event, which has whole seconds.
std::string second_text(double time) { return kube::time_text(time).substr(0, 19) + "Z"; }

}  // namespace

Events::Events(kube::Api& api, std::string name_space)
    : api_(api),
      path_("/api/v1/namespaces/" + name_space + "/events"),
      name_space_(std::move(name_space)),
      log_(random_hex(4)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void Events::record(kube::Happened what) {
  const std::lock_guard lock(mutex_);
  const auto write = log_.note(what, std::chrono::steady_clock::now());
  if (!write || waiting_.size() >= kMostWaiting) return;
  waiting_.push_back({std::move(what), *write});
  changed_.notify_all();
}

void Events::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return !waiting_.empty(); }) &&
         !stop.stop_requested()) {
    const Waiting one = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    write(one);
    lock.lock();
  }
}

void Events::write(const Waiting& one) {
  const std::string now = second_text(wall());
  const auto count = one.write.count;
  const auto written =
      count > 1
          ? api_.merge(path_ + "/" + one.write.name, {{"count", count}, {"lastTimestamp", now}})
          : api_.create(path_, {{"apiVersion", "v1"},
                                {"kind", "Event"},
                                {"metadata", {{"name", one.write.name}}},
                                {"involvedObject",
                                 {{"apiVersion", one.what.kind == "Pod" ? "v1" : kVersion},
                                  {"kind", one.what.kind},
                                  {"namespace", name_space_},
                                  {"name", one.what.name},
                                  {"uid", one.what.uid}}},
                                {"reason", one.what.reason},
                                {"message", one.what.message},
                                {"type", one.what.warning ? "Warning" : "Normal"},
                                {"source", {{"component", kManager}}},
                                {"firstTimestamp", now},
                                {"lastTimestamp", now},
                                {"count", 1}});
  if (!written) log::info("event_write_failed", {{"message", written.error().message}});
}

}  // namespace diaphane::fleet
