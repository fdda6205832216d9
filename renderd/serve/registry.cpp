#include "renderd/serve/registry.h"

#include <algorithm>

#include "common/log.h"
#include "directory/constants.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kBeat{1000};
constexpr milliseconds kSave{200};
// Shorter than the gateway's poll interval of two seconds. The gateway ends a stream when it has
// missed the worker in two polls.
constexpr milliseconds kMostBackoff{500};
// A dead worker is removed 3 s after its last heartbeat.
constexpr milliseconds kNameMayBeTaken{5000};

static_assert(kNameMayBeTaken.count() > directory::kHeartbeatMs);

directory::SavedScene record_of(const SavedSession& saved) {
  return {.placement = saved.placement,
          .scene = saved.scene,
          .input_seq = saved.input_seq,
          .width = saved.viewport.width,
          .height = saved.viewport.height,
          .presenter = saved.presenter,
          .guest_slices = saved.guest_slices};
}

}  // namespace

Registry::Registry(Options options, directory::Client& redis, SessionHost& host, Metrics& metrics)
    : options_(std::move(options)),
      host_(host),
      metrics_(metrics),
      directory_(redis, options_.worker_id, options_.incarnation),
      load_since_(steady_clock::now()) {
  thread_ = std::thread([this] { run(); });
}

Registry::~Registry() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (connected_) {
    (void)directory_.leave();
  }
}

void Registry::drain(milliseconds timeout) {
  std::unique_lock lock(mutex_);
  draining_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, timeout, [this] { return drain_reported_; });
}

void Registry::run() {
  auto next_beat = steady_clock::now();
  milliseconds backoff{100};
  bool drain_observed = false;
  bool first = true;
  for (;;) {
    bool reached = true;
    if (steady_clock::now() >= next_beat) {
      reached = heartbeat();
      next_beat = steady_clock::now() + kBeat;
    }
    reached = reached && save_scenes();
    if (reached != connected_ || first) {
      log::write(reached ? log::Level::kInfo : log::Level::kWarning,
                 reached ? "redis_connected" : "redis_lost");
    }
    connected_ = reached;
    first = false;
    if (reached) {
      backoff = milliseconds{100};
    } else {
      metrics_.redis_error();
      next_beat = steady_clock::now() + backoff;  // restores the worker as soon as Redis is back
    }
    std::unique_lock lock(mutex_);
    if (drain_observed && reached && !drain_reported_) {
      drain_reported_ = true;
      changed_.notify_all();
    }
    changed_.wait_for(lock, reached ? kSave : backoff,
                      [&] { return stopping_ || draining_ != drain_observed; });
    if (stopping_) return;
    if (!reached) backoff = std::min(2 * backoff, kMostBackoff);
    if (draining_ && !drain_observed) {
      drain_observed = true;
      next_beat = {};
    }
  }
}

Registry::Loads Registry::loads(const std::vector<SessionHost::Live>& live) {
  const double until_now = options_.busy_seconds();
  const auto now = steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - load_since_).count();
  const double busy = until_now - busy_before_;
  busy_before_ = until_now;
  load_since_ = now;
  const double lent_until_now = options_.lent_seconds ? options_.lent_seconds() : 0;
  const double lent = std::clamp(lent_until_now - lent_before_, 0.0, std::max(0.0, busy));
  lent_before_ = lent_until_now;
  std::vector<ExpectedLoad::Usage> usage;
  for (const SessionHost::Live& one : live) usage.push_back({one.id, one.device_seconds});
  return {.busy = seconds > 0 ? std::clamp(busy / seconds, 0.0, 1.0) : 0,
          .expected = expected_.after(seconds, busy - lent, usage, host_.slots())};
}

bool Registry::heartbeat() {
  bool draining = false;
  {
    const std::lock_guard lock(mutex_);
    draining = draining_ || drain_ordered_;
  }
  const std::vector<SessionHost::Live> live = host_.live();
  const Loads load = loads(live);
  directory::Heartbeat beat;
  beat.address = options_.address;
  beat.engine = options_.engine;
  beat.device = options_.device;
  beat.node = options_.node;
  beat.slots = host_.slots();
  beat.draining = draining;
  beat.load = load.busy;
  beat.expected = load.expected;
  beat.volumes = options_.volumes();
  for (const SessionHost::Live& one : live) {
    beat.sessions.push_back({one.id, one.placement, one.visitor});
  }
  const auto reply = directory_.beat(beat);
  if (!reply) {
    if (reply.error().code == ErrorCode::kInternal) {
      log::error("heartbeat_refused", {{"message", reply.error().message}});
    }
    return false;
  }
  if (reply->name_taken_by) {
    refused_name(*reply->name_taken_by);
    return false;
  }
  refused_since_.reset();
  report_render_time();
  if (!options_.owner.empty()) report_telemetry();
  for (const std::string& id : reply->ended) {
    log::info("session_moved_away", {{"session", id}});
    host_.moved_away(id);
  }
  for (const std::string& id : reply->unknown) write_again(id);
  return true;
}

void Registry::report_render_time() {
  const GpuTimeMeter::Account spent = host_.gpu_time().take_milliseconds();
  if (spent.empty()) return;
  // A failed report is sent again with the next heartbeat.
  if (!directory_.add_render_time(spent)) host_.gpu_time().give_back(spent);
}

void Registry::report_telemetry() {
  const auto room = directory_.report(
      {.owner = options_.owner, .memory = options_.memory(), .error = options_.error()});
  if (!room || !*room) return;
  if (!drain_ordered_) log::info("drain_requested");
  drain_ordered_ = true;
  // Another worker needs a session's scene to resume it.
  if (!save_scenes()) return;
  options_.drain_ordered(**room);
}

void Registry::write_again(const std::string& session) {
  const auto record = host_.recovery_record(session);
  if (!record) return;
  const auto written = directory_.restore({.id = session,
                                           .user_id = record->user_id,
                                           .data_set_id = record->volume_id,
                                           .saved = record_of(record->saved),
                                           .visitor = record->visitor,
                                           .over = record->over,
                                           .to_first = record->to_first,
                                           .links = record->links});
  if (written && *written) log::info("session_restored", {{"session", session}});
}

void Registry::refused_name(const std::string& holder) {
  const auto now = steady_clock::now();
  if (!refused_since_) {
    refused_since_ = now;
    log::warning("name_taken", {{"worker", options_.worker_id}, {"by", holder}});
  }
  if (refusal_reported_ || now - *refused_since_ < kNameMayBeTaken) return;
  refusal_reported_ = true;
  if (options_.name_taken) options_.name_taken(holder);
}

bool Registry::save_scenes() {
  std::vector<SavedSession> unsaved = host_.take_unsaved();
  for (std::size_t i = 0; i < unsaved.size(); ++i) {
    if (directory_.save_scene(unsaved[i].id, record_of(unsaved[i]))) continue;
    for (; i < unsaved.size(); ++i) host_.mark_unsaved(unsaved[i].id);
    return false;
  }
  return true;
}

}  // namespace diaphane::render
