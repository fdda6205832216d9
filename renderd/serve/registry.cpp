#include "renderd/serve/registry.h"

#include <algorithm>
#include <cstdio>

#include "common/log.h"
#include "renderd/serve/goodbye.lua.h"
#include "renderd/serve/heartbeat.lua.h"
#include "renderd/serve/note_render_time.lua.h"
#include "renderd/serve/rebuild_session.lua.h"
#include "renderd/serve/report_to_fleet.lua.h"
#include "renderd/serve/save_scene.lua.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kBeat{1000};
constexpr milliseconds kSave{200};
constexpr milliseconds kMostBackoff{2000};
// A worker that died is forgotten 3 s after its last heartbeat.
constexpr milliseconds kNameMayBeTaken{5000};

constexpr char kWorkers[] = "diaphane:workers";
constexpr char kSessionPrefix[] = "diaphane:session:";
constexpr char kLinkPrefix[] = "diaphane:link:";
constexpr char kRenderTime[] = "diaphane:render_time";
constexpr std::chrono::seconds kLinkLife{12 * 3600};
std::string worker_key(const std::string& id) { return "diaphane:worker:" + id; }
std::string sessions_key(const std::string& id) { return worker_key(id) + ":sessions"; }

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
  return text;
}

}  // namespace

Registry::Registry(Options options, SessionHost& host, Metrics& metrics)
    : options_(std::move(options)),
      host_(host),
      metrics_(metrics),
      redis_(options_.redis),
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
    (void)redis_.run(lua::goodbye,
                     {kWorkers, worker_key(options_.worker_id), sessions_key(options_.worker_id)},
                     {options_.worker_id, options_.incarnation});
  }
}

void Registry::drain(milliseconds timeout) {
  std::unique_lock lock(mutex_);
  draining_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, timeout, [this] { return drain_told_; });
}

void Registry::run() {
  auto next_beat = steady_clock::now();
  milliseconds backoff{100};
  bool drain_seen = false;
  bool first = true;
  for (;;) {
    bool told = true;
    if (steady_clock::now() >= next_beat) {
      told = heartbeat();
      next_beat = steady_clock::now() + kBeat;
    }
    told = told && save_scenes();
    if (told != connected_ || first) {
      log::write(told ? log::Level::kInfo : log::Level::kWarning,
                 told ? "redis_connected" : "redis_lost");
    }
    connected_ = told;
    first = false;
    if (told) {
      backoff = milliseconds{100};
    } else {
      metrics_.redis_error();
      next_beat = steady_clock::now() + backoff;  // the first thing that Redis hears again
    }
    std::unique_lock lock(mutex_);
    if (drain_seen && told && !drain_told_) {
      drain_told_ = true;
      changed_.notify_all();
    }
    changed_.wait_for(lock, told ? kSave : backoff,
                      [&] { return stopping_ || draining_ != drain_seen; });
    if (stopping_) return;
    if (!told) backoff = std::min(2 * backoff, kMostBackoff);
    if (draining_ && !drain_seen) {
      drain_seen = true;
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
  std::vector<ExpectedLoad::Seen> seen;
  for (const SessionHost::Live& one : live) seen.push_back({one.id, one.device_seconds});
  return {.busy = seconds > 0 ? std::clamp(busy / seconds, 0.0, 1.0) : 0,
          .expected = expected_.after(seconds, busy - lent, seen, host_.slots())};
}

bool Registry::heartbeat() {
  bool draining = false;
  {
    const std::lock_guard lock(mutex_);
    draining = draining_ || told_to_drain_;
  }
  const std::vector<SessionHost::Live> live = host_.live();
  const Loads load = loads(live);
  char busy[16], expected[16];
  std::snprintf(busy, sizeof busy, "%.3f", load.busy);
  std::snprintf(expected, sizeof expected, "%.4f", load.expected);
  std::vector<std::string> visitors;
  for (const SessionHost::Live& one : live) {
    if (one.visitor) visitors.push_back(one.id);
  }
  std::vector<std::string> arguments{
      options_.worker_id, options_.incarnation,          options_.address,     options_.engine,
      options_.device,    std::to_string(host_.slots()), draining ? "1" : "0", busy,
      expected,           joined(options_.volumes()),    kSessionPrefix,       joined(visitors)};
  for (const SessionHost::Live& one : live) {
    arguments.push_back(one.id);
    arguments.push_back(std::to_string(one.placement));
  }
  const auto answer = redis_.run(
      lua::heartbeat, {kWorkers, worker_key(options_.worker_id), sessions_key(options_.worker_id)},
      arguments);
  if (!answer) {
    if (answer.error().code == ErrorCode::kInternal) {
      log::error("heartbeat_refused", {{"message", answer.error().message}});
    }
    return false;
  }
  if (answer->list.size() == 2 && answer->list.front() == "name_taken") {
    refused_name(answer->list.back());
    return false;
  }
  refused_since_.reset();
  note_render_time();
  if (!options_.owner.empty()) report_to_fleet();
  bool unknown = false;
  for (const std::string& id : answer->list) {
    if (id.empty()) {
      unknown = true;
    } else if (unknown) {
      write_again(id);
    } else {
      log::info("session_moved_away", {{"session", id}});
      host_.moved_away(id);
    }
  }
  return true;
}

void Registry::note_render_time() {
  const SpentTime::Account spent = host_.spent().take_milliseconds();
  if (spent.empty()) return;
  std::vector<std::string> arguments;
  for (const auto& [user, ms] : spent) {
    arguments.push_back(user);
    arguments.push_back(std::to_string(ms));
  }
  // Told with the next heartbeat, when this one was not heard.
  if (!redis_.run(lua::note_render_time, {kRenderTime}, arguments)) host_.spent().give_back(spent);
}

void Registry::report_to_fleet() {
  char memory[16], error[24];
  std::snprintf(memory, sizeof memory, "%.3f", options_.memory());
  std::snprintf(error, sizeof error, "%.4g", options_.error());
  const std::string key = worker_key(options_.worker_id);
  const auto room =
      redis_.run(lua::report_to_fleet, {kWorkers, key, key + ":drain"},
                 {options_.worker_id, options_.incarnation, options_.owner, memory, error});
  if (!room || room->number < 0) return;
  if (!told_to_drain_) log::info("told_to_drain");
  told_to_drain_ = true;
  // Whoever takes a session up needs its scene.
  if (!save_scenes()) return;
  options_.told_to_drain(static_cast<std::size_t>(room->number));
}

void Registry::write_again(const std::string& session) {
  const auto lost = host_.lost(session);
  if (!lost) return;
  const LiveSession::Saved& saved = lost->saved;
  const std::string key = kSessionPrefix + session;
  std::vector<std::string> arguments{session,
                                     lost->user_id,
                                     lost->volume_id,
                                     options_.worker_id,
                                     options_.incarnation,
                                     std::to_string(saved.placement),
                                     saved.scene,
                                     std::to_string(saved.input_seq),
                                     std::to_string(saved.viewport.width),
                                     std::to_string(saved.viewport.height),
                                     saved.presenter,
                                     saved.guest_slices ? "1" : "0",
                                     kLinkPrefix,
                                     std::to_string(kLinkLife.count()),
                                     lost->visitor ? "1" : ""};
  arguments.insert(arguments.end(), lost->links.begin(), lost->links.end());
  const auto written =
      redis_.run(lua::rebuild_session,
                 {key, key + ":links", "diaphane:user:" + lost->user_id + ":sessions",
                  "diaphane:data_set:" + lost->volume_id + ":sessions"},
                 arguments);
  if (written && written->number == 1) log::info("session_written_again", {{"session", session}});
}

void Registry::refused_name(const std::string& holder) {
  const auto now = steady_clock::now();
  if (!refused_since_) {
    refused_since_ = now;
    log::warning("name_taken", {{"worker", options_.worker_id}, {"by", holder}});
  }
  if (refusal_told_ || now - *refused_since_ < kNameMayBeTaken) return;
  refusal_told_ = true;
  if (options_.name_taken) options_.name_taken(holder);
}

bool Registry::save_scenes() {
  std::vector<LiveSession::Saved> unsaved = host_.take_unsaved();
  for (std::size_t i = 0; i < unsaved.size(); ++i) {
    const LiveSession::Saved& saved = unsaved[i];
    const auto written =
        redis_.run(lua::save_scene, {kSessionPrefix + saved.id},
                   {std::to_string(saved.placement), saved.scene, std::to_string(saved.input_seq),
                    std::to_string(saved.viewport.width), std::to_string(saved.viewport.height),
                    saved.presenter, saved.guest_slices ? "1" : "0"});
    if (written) continue;
    for (; i < unsaved.size(); ++i) host_.mark_unsaved(unsaved[i].id);
    return false;
  }
  return true;
}

}  // namespace diaphane::render
