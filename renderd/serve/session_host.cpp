#include "renderd/serve/session_host.h"

#include <algorithm>

#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"
#include "renderd/serve/evict.h"

namespace diaphane::render {
namespace {

const Error& stopping() {
  static const Error error{
      ErrorCode::kUnavailable,
      "This rendering server is shutting down. The session continues on another one.",
      {}};
  return error;
}

constexpr char kVisitorSlot[] = "visitor_slot";

Result<LiveSession::Start> start_of(const v1::Open& open) {
  if (!is_id(open.session_id()))
    return fail(ErrorCode::kInvalid, "The session ID is missing or invalid.", "session_id");
  if (!is_id(open.volume_id()))
    return fail(ErrorCode::kInvalid, "The volume ID is missing or invalid.", "volume_id");
  LiveSession::Start start;
  start.facts.id = open.session_id();
  start.facts.volume_id = open.volume_id();
  if (open.has_second()) {
    if (!is_id(open.second().volume_id())) {
      return fail(ErrorCode::kInvalid, "The ID of the second volume is invalid.",
                  "second.volume_id");
    }
    const auto& numbers = open.second().to_first();
    const auto to_first =
        volume::rigid_motion({numbers.data(), static_cast<std::size_t>(numbers.size())});
    DIAPHANE_TRY(to_first);
    start.facts.second = {open.second().volume_id(), *to_first};
  }
  start.placement = open.placement();
  start.input_seq = open.input_seq();
  start.presenter = open.presenter();
  start.guest_slices = open.guest_slices();
  start.visitor = open.visitor();
  if (is_id(open.user_id())) start.facts.user_id = start.facts.charged_to = open.user_id();
  if (open.has_scene()) start.scene = std::make_shared<const v1::Scene>(open.scene());
  if (open.has_viewport()) {
    // The saved viewport may be unusable. The browser's Hello contains the current one.
    if (const auto viewport = check_viewport(open.viewport())) start.viewport = *viewport;
  }
  return start;
}

Result<JoinRequest> join_request_of(const v1::Open& open) {
  JoinRequest join;
  if (!open.participant().empty()) {
    if (!is_id(open.participant())) {
      return fail(ErrorCode::kInvalid, "The participant ID is missing or invalid.", "participant");
    }
    join.participant = open.participant();
  }
  join.name = open.name();
  constexpr std::size_t kLongestLink = 64;
  if (open.link().size() <= kLongestLink) join.link = open.link();
  join.viewer = join.link.empty() ? viewer_of(open.viewer()) : ViewerKind::kGuest;
  join.may_have_slices = open.slices() || join.viewer == ViewerKind::kOwner;
  join.may_download = open.downloads() || join.viewer == ViewerKind::kOwner;
  return join;
}

}  // namespace

const Error& displaced() {
  static const Error error{ErrorCode::kTooMany, "Your place was given to a signed-in user.",
                           kVisitorSlot};
  return error;
}

bool is_displaced(const Error& why) {
  return why.code == ErrorCode::kTooMany && why.field == kVisitorSlot;
}

SessionHost::SessionHost(Options options, Homes& homes, EncodePool& encoders, VolumeCache& volumes,
                         const VolumeStatsCache& stats, SliceParts slices, EncodePool& textures,
                         Metrics& metrics, const Clock& clock)
    : options_(options),
      homes_(homes),
      encoders_(encoders),
      volumes_(volumes),
      stats_(stats),
      slices_(slices),
      textures_(textures),
      metrics_(metrics),
      clock_(clock) {}

SessionHost::~SessionHost() { end_all(); }

Result<Attachment> SessionHost::open(const v1::Open& open, std::shared_ptr<ClientLink> link) {
  auto start = start_of(open);
  DIAPHANE_TRY(start);
  const auto join = join_request_of(open);
  DIAPHANE_TRY(join);
  const std::string id = start->facts.id;
  const std::string volume_id = start->facts.volume_id;
  const auto second = start->facts.second;

  Session session;
  Session evicted;
  bool is_new = false;
  std::uint64_t connection = 0;
  {
    const std::lock_guard lock(mutex_);
    if (refusing_) return tl::unexpected(stopping());
    if (const auto found = sessions_.find(id); found != sessions_.end()) {
      session = found->second;
      if (open.placement() < session->status().placement) {
        return fail(ErrorCode::kConflict, "The session has since moved to another worker.");
      }
      if (session->facts().volume_id != volume_id || session->facts().second != second) {
        return fail(ErrorCode::kInvalid, "The session belongs to a different volume.", "volume_id");
      }
    } else {
      if (full()) {
        return fail(ErrorCode::kOutOfMemory,
                    "This rendering server is out of memory. The session opens on another one.");
      }
      if (open.visitor() &&
          visitors() >= visitor_slots_of_worker(options_.slots, options_.visitor_percent)) {
        return fail(ErrorCode::kTooMany, "All guest places are taken.");
      }
      if (sessions_.size() >= options_.slots && !(evicted = evict(open.visitor()))) {
        return fail(ErrorCode::kTooMany, "All slots of this rendering server are in use.");
      }
      is_new = true;
      session = std::make_shared<LiveSession>(parts(), std::move(*start), when_ended(id));
      sessions_.emplace(id, session);
      metrics_.sessions(sessions_.size());
    }
    const auto attached =
        session->attach(std::move(link), *join, {open.placement(), open.visitor()});
    DIAPHANE_TRY(attached);
    connection = *attached;
  }
  if (evicted) end_evicted(evicted);
  if (is_new) {
    log::info("session_opened", {{"session", id}, {"volume", volume_id}});
    session->start();
  }
  return Attachment(std::move(session), connection);
}

SessionParts SessionHost::parts() {
  return {homes_.take(),
          encoders_,
          metrics_,
          clock_,
          [this](const LiveSession& group, const FreeCameraStart& camera) {
            return open_free_camera(group, camera);
          },
          options_.mark_frames,
          gpu_time_,
          stats_,
          volumes_,
          slices_,
          files_,
          textures_};
}

// Opens a session to which no ticket leads, because only this worker knows its id. The heartbeat
// counts its slot.
Result<SessionHost::Session> SessionHost::open_free_camera(const LiveSession& group,
                                                           const FreeCameraStart& camera) {
  LiveSession::Start start;
  const SessionStatus of_group = group.status();
  start.facts.id = new_id();
  start.facts.volume_id = group.facts().volume_id;
  start.facts.second = group.facts().second;
  start.facts.charged_to = group.facts().charged_to;
  start.facts.camera_only = true;
  start.facts.link = camera.link;
  start.facts.group = camera.group;
  start.placement = of_group.placement;
  start.scene = camera.scene;
  start.viewport = camera.viewport;
  start.presenter = camera.participant;
  const bool by_guest = camera.participant != kOwner;
  start.visitor = by_guest || of_group.visitor;
  const std::string id = start.facts.id;
  Session session;
  Session evicted;
  {
    const std::lock_guard lock(mutex_);
    if (refusing_) return tl::unexpected(stopping());
    const std::size_t share = visitor_slots(options_.slots, options_.visitor_percent);
    const bool over = start.visitor && (visitors() >= share ||
                                        cameras_of(camera.link) >= visitor_slots_of_source(share));
    if (over || (sessions_.size() >= options_.slots && !(evicted = evict(start.visitor)))) {
      return fail(ErrorCode::kTooMany, "No slot is free for a camera of your own. Try again later.",
                  "own_camera");
    }
    session = std::make_shared<LiveSession>(parts(), std::move(start), when_ended(id));
    sessions_.emplace(id, session);
    metrics_.sessions(sessions_.size());
  }
  if (evicted) end_evicted(evicted);
  session->start();
  return session;
}

SessionHost::Session SessionHost::evict(bool for_visitor) {
  std::vector<SlotHolder> holders;
  for (const auto& [id, session] : sessions_) {
    const SessionStatus status = session->status();
    holders.push_back(
        {id, status.visitor, session->facts().camera_only, status.abandoned_for, status.age});
  }
  const auto chosen = to_evict(holders, for_visitor);
  if (!chosen) return nullptr;
  return std::move(sessions_.extract(*chosen).mapped());
}

// Excludes sessions whose visitor has left, because they give way to anyone (to_evict). Otherwise
// two of them could keep a guest from a free camera for half a minute.
std::size_t SessionHost::visitors() const {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [](const auto& one) {
        const SessionStatus status = one.second->status();
        return status.visitor && (one.second->facts().camera_only || !status.abandoned_for);
      }));
}

std::size_t SessionHost::cameras_of(const std::string& link) const {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [&](const auto& one) {
        const SessionFacts& facts = one.second->facts();
        return facts.camera_only && one.second->status().visitor && facts.link == link;
      }));
}

void SessionHost::end_evicted(const Session& session) {
  const SessionFacts& facts = session->facts();
  const SessionStatus status = session->status();
  const bool abandoned = status.abandoned_for.has_value();
  log::info("session_evicted",
            {{"session", facts.id}, {"visitor", status.visitor}, {"abandoned", abandoned}});
  // A guest who loses their free camera follows the presenter again.
  if (const auto group = facts.group.lock()) {
    if (group->take_camera_back(facts.id)) return;
    // The guest may be about to connect to the session, and is notified in that case too.
    session->dismiss();
    (void)group->take_camera_back(facts.id);
    return;
  }
  session->end(status.visitor && !abandoned ? displaced() : stopping());
}

void SessionHost::forget(const std::string& id, const LiveSession* session) {
  Session last;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found == sessions_.end() || (session && found->second.get() != session)) return;
  last = std::move(found->second);
  sessions_.erase(found);
  freed();
}

std::function<void(const Error&)> SessionHost::when_ended(const std::string& id) {
  return [this, id](const Error& why) {
    forget(id, nullptr);
    if (why.code == ErrorCode::kOutOfMemory) out_of_memory();
  };
}

void SessionHost::out_of_memory() {
  if (options_.reclaim && options_.reclaim()) return;
  Session abandoned;
  {
    const std::lock_guard lock(mutex_);
    // Evicts a session, an abandoned visitor's first, so that the next one finds memory.
    if ((abandoned = evict(true)) || (abandoned = evict(false))) {
      freed();
    } else {
      full_until_ = clock_.now() + options_.full_for;
    }
  }
  log::warning("device_full", {{"evicted", abandoned != nullptr}});
  if (abandoned) end_evicted(abandoned);
}

bool SessionHost::full() const { return clock_.now() < full_until_; }

void SessionHost::freed() {
  full_until_ = {};
  metrics_.sessions(sessions_.size());
}

void SessionHost::tick() {
  const std::size_t sessions = used();
  for (const Session& session : all()) {
    session->tick(sessions);
    const auto abandoned = session->status().abandoned_for;
    if (!abandoned || *abandoned < options_.keep_abandoned) continue;
    {
      // The viewer may have returned before the lock was taken.
      const std::lock_guard lock(mutex_);
      if (!session->status().abandoned_for) continue;
      sessions_.erase(session->facts().id);
      freed();
    }
    session->end(stopping());
    log::info("session_dropped", {{"session", session->facts().id}});
  }
  metrics_.volumes(volumes_.bytes());
}

void SessionHost::refuse_new() {
  const std::lock_guard lock(mutex_);
  refusing_ = true;
}

void SessionHost::end_all() {
  std::map<std::string, Session> ending;
  {
    const std::lock_guard lock(mutex_);
    refusing_ = true;
    ending.swap(sessions_);
    metrics_.sessions(0);
  }
  for (const auto& [id, session] : ending) session->end(stopping());
}

void SessionHost::move_away(std::size_t count) {
  std::vector<Session> ending;
  {
    const std::lock_guard lock(mutex_);
    refusing_ = true;
    for (auto at = sessions_.begin(); at != sessions_.end() && ending.size() < count;) {
      ending.push_back(std::move(at->second));
      at = sessions_.erase(at);
      freed();
    }
  }
  for (const Session& session : ending) session->end(stopping());
}

void SessionHost::moved_away(const std::string& id) {
  Session session;
  {
    const std::lock_guard lock(mutex_);
    const auto found = sessions_.find(id);
    if (found == sessions_.end()) return;
    session = std::move(found->second);
    sessions_.erase(found);
    freed();
  }
  session->end({ErrorCode::kConflict, "This session has ended on this worker.", {}});
}

void SessionHost::volume_gone(const std::string& volume_id) {
  std::vector<Session> ending;
  {
    const std::lock_guard lock(mutex_);
    for (auto entry = sessions_.begin(); entry != sessions_.end();) {
      if (!entry->second->facts().shows(volume_id)) {
        ++entry;
        continue;
      }
      ending.push_back(std::move(entry->second));
      entry = sessions_.erase(entry);
      freed();
    }
  }
  for (const Session& session : ending) {
    session->end({ErrorCode::kNotFound, "This scan was changed or deleted.", {}});
  }
}

void SessionHost::labels_changed(const std::string& volume_id) {
  for (const Session& session : all()) {
    if (session->facts().volume_id == volume_id) session->labels_changed();
  }
}

std::vector<SessionHost::Session> SessionHost::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<Session> sessions;
  for (const auto& [id, session] : sessions_) sessions.push_back(session);
  return sessions;
}

std::vector<SessionHost::Live> SessionHost::live() const {
  std::vector<Live> live;
  for (const Session& session : all()) {
    const SessionStatus status = session->status();
    live.push_back({session->facts().id, status.placement, status.device_seconds, status.visitor});
  }
  return live;
}

std::vector<SavedSession> SessionHost::take_unsaved() {
  std::vector<SavedSession> unsaved;
  for (const Session& session : all()) {
    if (auto saved = session->take_unsaved()) unsaved.push_back(std::move(*saved));
  }
  return unsaved;
}

void SessionHost::mark_unsaved(const std::string& id) {
  const std::lock_guard lock(mutex_);
  if (const auto found = sessions_.find(id); found != sessions_.end())
    found->second->mark_unsaved();
}

SessionHost::Session SessionHost::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  return found == sessions_.end() ? nullptr : found->second;
}

std::optional<RecoveryRecord> SessionHost::recovery_record(const std::string& id) const {
  const Session session = find(id);
  if (!session) return std::nullopt;
  return session->recovery_record();
}

std::optional<v1::ErrorCurve> SessionHost::error_curve(const std::string& id) const {
  const Session session = find(id);
  if (!session) return std::nullopt;
  return session->error_curve();
}

std::size_t SessionHost::slots() const {
  const std::lock_guard lock(mutex_);
  return full() ? std::min(sessions_.size(), options_.slots) : options_.slots;
}

std::size_t SessionHost::used() const {
  const std::lock_guard lock(mutex_);
  return sessions_.size();
}

}  // namespace diaphane::render
