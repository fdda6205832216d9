#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/worker.pb.h"
#include "common/visitor_share.h"
#include "renderd/serve/live_session.h"
#include "renderd/session/volume_cache.h"

namespace diaphane::render {

/// The error of a visitor whose slot an account holder needed.
const Error& displaced();
bool is_displaced(const Error& why);

/// One connection's hold on a session.
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

/// The sessions of this worker: opened, joined, kept a while after their last viewer left, ended.
class SessionHost {
 public:
  struct Options {
    std::size_t slots = 4;  ///< sessions at most, those that wait for a viewer included
    /// Of the slots, that visitors' sessions and guests' own cameras may have together. They lose
    /// theirs when an account holder finds none free.
    int visitor_percent = kVisitorPercent;
    std::chrono::seconds keep_abandoned{30};  ///< so that a reload is where one was
    /// After a session found no memory on the device, unless one ends before.
    std::chrono::seconds full_for{10};
    bool mark_frames = false;  ///< for a bench: input_seq in the pixels (encode/frame_mark.h)
  };
  /// What the heartbeat tells of a session.
  struct Live {
    std::string id;
    std::uint64_t placement = 0;
    double device_seconds = 0;  ///< since it is here
    bool visitor = false;       ///< of somebody without an account, or a guest's own camera
  };

  SessionHost(Options options, Engine& engine, Runner& runner, EncodePool& encoders,
              VolumeCache& volumes, const KeptFacts& facts, SliceParts slices, EncodePool& textures,
              Metrics& metrics, const Clock& clock);
  ~SessionHost();

  /// Opens a session or joins one that is here. kTooMany: no slot is free, or as many viewers as
  /// can be are there; kConflict: it was placed anew since; kUnavailable: draining; kInvalid: an
  /// identifier that is none.
  Result<Attachment> open(const diaphane::v1::Open& open, std::shared_ptr<ClientLink> link);

  /// Ends what nobody came back to; once or more a second.
  void tick();
  /// Refuses new sessions from now on.
  void refuse_new();
  /// Ends so many, as end_all does, of those that somebody looks at; refuses new ones.
  void move_away(std::size_t count);
  /// Ends all with a fatal Problem "unavailable", so that their viewers come back elsewhere.
  void end_all();
  /// It lives on another worker now, or was ended in Redis: ended here.
  void moved_away(const std::string& id);

  /// The store has this volume no more, or another under its id: its sessions end with NOT_FOUND.
  void volume_gone(const std::string& volume_id);

  std::vector<Live> live() const;
  std::vector<LiveSession::Saved> take_unsaved();
  void mark_unsaved(const std::string& id);
  std::optional<LiveSession::Lost> lost(const std::string& id) const;
  /// Of those who have sessions here.
  SpentTime& spent() { return spent_; }
  std::size_t used() const;
  /// That may be filled: while the device's memory is full, no more than are taken already.
  std::size_t slots() const;

 private:
  using Session = std::shared_ptr<LiveSession>;
  Result<Session> branch(const LiveSession& group, const Branch& wanted);
  SessionParts parts();
  void forget(const std::string& id, const LiveSession* session);
  /// What a session that ends by itself calls.
  std::function<void(const Error&)> when_ended(const std::string& id);
  /// A session ended because the device had no memory for it.
  void out_of_memory();
  bool full() const;  // under the lock
  void freed();       // under the lock: a session ended
  /// Takes out the session that makes room, for a visitor or for an account holder (to_evict).
  /// Under the lock; empty when there is none.
  Session evict(bool for_visitor);
  /// How many slots visitors and guests hold, and of those the own cameras of one link's guests.
  /// Under the lock.
  std::size_t visitors() const;
  std::size_t cameras_of(const std::string& link) const;
  /// Ends one that was evicted; without the lock.
  void end_evicted(const Session& session);
  std::vector<Session> all() const;

  const Options options_;
  Engine& engine_;
  Runner& runner_;
  EncodePool& encoders_;
  VolumeCache& volumes_;
  const KeptFacts& facts_;
  const SliceParts slices_;
  EncodePool& textures_;
  Metrics& metrics_;
  const Clock& clock_;

  SpentTime spent_;
  std::atomic<int> files_{0};
  mutable std::mutex mutex_;
  std::map<std::string, Session> sessions_;
  bool refusing_ = false;
  std::chrono::steady_clock::time_point full_until_{};
};

}  // namespace diaphane::render
