#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/worker.pb.h"
#include "common/visitor_share.h"
#include "renderd/serve/homes.h"
#include "renderd/serve/live_session.h"
#include "renderd/session/volume_cache.h"

namespace diaphane::render {

/// Returns the error for a visitor whose slot went to an account holder.
const Error& displaced();
bool is_displaced(const Error& why);

/// The connection of one viewer to a session.
class Attachment {
 public:
  Attachment(std::shared_ptr<LiveSession> session, std::uint64_t connection)
      : session_(std::move(session)), connection_(connection) {}
  void receive(const std::string& client_message) {
    session_->receive(connection_, client_message);
  }
  void closed() { session_->closed(connection_); }

 private:
  std::shared_ptr<LiveSession> session_;
  std::uint64_t connection_;
};

/// The sessions of this worker: opens and joins them, keeps them for a while after their last
/// viewer left, and ends them.
class SessionHost {
 public:
  struct Options {
    std::size_t slots = 4;  ///< maximum number of sessions, including abandoned ones
    /// Maximum share of the slots for visitors' sessions and guests' free cameras. They lose their
    /// slots when an account holder finds none free.
    int visitor_percent = kVisitorPercent;
    /// How long a session without viewers is kept, so that a page can be reloaded.
    std::chrono::seconds keep_abandoned{30};
    /// How long the device counts as full after it ran out of memory for a session, unless a
    /// session ends before.
    std::chrono::seconds full_for{10};
    /// Frees device memory that other workers' pictures use, and returns whether there was any.
    /// May be empty.
    std::function<bool()> reclaim;
    /// For benches: draws input_seq into the pixels (encode/frame_mark.h).
    bool mark_frames = false;
  };
  /// The state of a session that the heartbeat reports.
  struct Live {
    std::string id;
    std::uint64_t placement = 0;
    double device_seconds = 0;  ///< device time since it was opened on this worker
    bool visitor = false;       ///< whether it belongs to a visitor or is a guest's free camera
  };

  SessionHost(Options options, Homes& homes, EncodePool& encoders, VolumeCache& volumes,
              const VolumeStatsCache& stats, SliceParts slices, EncodePool& textures,
              Metrics& metrics, const Clock& clock);
  ~SessionHost();

  /// Opens a session or joins an existing one. Fails with kTooMany if no slot is free or the
  /// session is full, with kConflict if the session was placed again since, with kUnavailable while
  /// draining, and with kInvalid if an identifier is invalid.
  Result<Attachment> open(const diaphane::v1::Open& open, std::shared_ptr<ClientLink> link);

  /// Ends abandoned sessions. To be called at least once per second.
  void tick();
  /// Refuses new sessions from now on.
  void refuse_new();
  /// Ends this many sessions that have viewers, as end_all() does, and refuses new ones.
  void move_away(std::size_t count);
  /// Ends all sessions with a fatal Problem "unavailable", so that their viewers reconnect to
  /// another worker.
  void end_all();
  /// Ends a session that moved to another worker or was ended in Redis.
  void moved_away(const std::string& id);

  /// Ends the sessions of a volume that was deleted or replaced in the store with NOT_FOUND.
  void volume_gone(const std::string& volume_id);
  /// Lets the sessions of a volume show its new labels.
  void labels_changed(const std::string& volume_id);

  std::vector<Live> live() const;
  std::vector<SavedSession> take_unsaved();
  void mark_unsaved(const std::string& id);
  std::optional<RecoveryRecord> recovery_record(const std::string& id) const;
  /// Returns the error curve of a session, or nullopt if this worker has no such session.
  std::optional<diaphane::v1::ErrorCurve> error_curve(const std::string& id) const;
  /// Returns the render time of users with sessions on this worker.
  GpuTimeMeter& gpu_time() { return gpu_time_; }
  std::size_t used() const;
  /// Returns the number of usable slots. While the device's memory is full, these are the occupied
  /// ones.
  std::size_t slots() const;

 private:
  using Session = std::shared_ptr<LiveSession>;
  Result<Session> open_free_camera(const LiveSession& group, const FreeCameraStart& camera);
  SessionParts parts();
  void forget(const std::string& id, const LiveSession* session);
  /// Returns the callback for a session that ends on its own.
  std::function<void(const Error&)> when_ended(const std::string& id);
  /// Makes room after a session found no memory: evicts another one or counts the device as full.
  void out_of_memory();
  bool full() const;  // requires the lock
  void freed();       // requires the lock; called when a session ended
  /// Removes the session that makes room for a visitor or an account holder (to_evict). Returns
  /// null if there is none. Requires the lock.
  Session evict(bool for_visitor);
  /// Count the slots of visitors and guests, and of those the free cameras of one link's guests.
  /// Require the lock.
  std::size_t visitors() const;
  std::size_t cameras_of(const std::string& link) const;
  /// Ends an evicted session. Must be called without the lock.
  void end_evicted(const Session& session);
  std::vector<Session> all() const;
  Session find(const std::string& id) const;  // null if there is none

  const Options options_;
  Homes& homes_;
  EncodePool& encoders_;
  VolumeCache& volumes_;
  const VolumeStatsCache& stats_;
  const SliceParts slices_;
  EncodePool& textures_;
  Metrics& metrics_;
  const Clock& clock_;

  GpuTimeMeter gpu_time_;
  std::atomic<int> files_{0};
  mutable std::mutex mutex_;
  std::map<std::string, Session> sessions_;
  bool refusing_ = false;
  std::chrono::steady_clock::time_point full_until_{};
};

}  // namespace diaphane::render
