#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/clock.h"
#include "renderd/encode/encode_lane.h"
#include "renderd/scene/light_textures.h"
#include "renderd/schedule/runner.h"
#include "renderd/serve/file_work.h"
#include "renderd/serve/gpu_time_meter.h"
#include "renderd/serve/homes.h"
#include "renderd/serve/metrics.h"
#include "renderd/session/collaboration.h"
#include "renderd/session/convergence.h"
#include "renderd/session/depth.h"
#include "renderd/session/files.h"
#include "renderd/session/free_cameras.h"
#include "renderd/session/lossless_tiles.h"
#include "renderd/session/pictures.h"
#include "renderd/session/saving.h"
#include "renderd/session/slices.h"
#include "renderd/session/volume_cache.h"
#include "renderd/session/volume_stats.h"

namespace diaphane::render {

/// The connection of one viewer. The calls neither block nor call back.
class ClientLink {
 public:
  virtual ~ClientLink() = default;
  /// Sends a serialised ServerMessage.
  virtual void send(std::string server_message) = 0;
  /// Ends the connection after all sent messages. `why` becomes its status.
  virtual void finish(const Error& why) = 0;
};

class LiveSession;

/// The initial state of the session for a follower's free camera.
struct FreeCameraStart {
  std::string participant;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas viewport;
  std::string link;                    ///< link by which they joined; empty: the owner
  std::weak_ptr<LiveSession> group{};  ///< the session whose scene it follows
};

/// Resources for reading and encoding slices. They are separate from those for pictures, so that
/// neither waits for the other.
struct SliceParts {
  VolumeCache& voxels;  ///< holds HostVolume objects
  EncodePool& pool;     ///< holds at most one slice per viewer
};

/// The second scan of a session, and how it lies (api/proto/worker.proto, SecondScan).
struct SecondFacts {
  std::string volume_id;
  volume::Matrix to_first = volume::kIdentity;
  bool operator==(const SecondFacts&) const = default;
};

/// The properties of a session that never change.
struct SessionFacts {
  std::string id;
  std::string volume_id;
  std::string user_id;                    ///< owner of the session
  std::string charged_to;                 ///< user whose render time is charged; empty: no user
  bool camera_only = false;               ///< a follower's free camera
  std::string link = {};                  ///< link by which a guest with a free camera joined
  std::weak_ptr<LiveSession> group = {};  ///< session that a follower with a free camera follows
  std::optional<SecondFacts> second = {};

  bool shows(const std::string& volume) const {
    return volume_id == volume || (second && second->volume_id == volume);
  }
};

/// The state of a session at one moment, as the host needs it.
struct SessionStatus {
  std::uint64_t placement = 0;
  double device_seconds = 0;  ///< device time of its samples
  /// Whether the session counts towards the visitors' share. May change when the session is opened
  /// again with or without an account.
  bool visitor = false;
  std::chrono::steady_clock::duration age{};  ///< how long the session has held its slot
  /// How long the session has had no viewers; nullopt if it has one.
  std::optional<std::chrono::steady_clock::duration> abandoned_for;
};

/// Resources of the process that a session uses. They outlive the session.
struct SessionParts {
  std::shared_ptr<const Home> home;
  EncodePool& encoders;
  Metrics& metrics;
  const Clock& clock;
  /// Creates a session for a follower's free camera, in a separate slot. Fails with kTooMany if no
  /// slot is free.
  std::function<Result<std::shared_ptr<LiveSession>>(const LiveSession& group,
                                                     const FreeCameraStart&)>
      open_free_camera;
  bool mark_frames = false;  ///< whether benches can read input_seq from the pixels
                             ///< (encode/frame_mark.h)
  GpuTimeMeter& gpu_time;
  const VolumeStatsCache& stats;
  VolumeCache& volumes;
  SliceParts slices;
  std::atomic<int>& files;  ///< number of files that this worker is making
  /// Decodes textures, one at a time, in parallel to everything else, because it takes up to a
  /// second.
  EncodePool& textures;
};

/// One session. It connects the rules in renderd/session to the runner, the encoders and the
/// connections of all viewers: one render, one encoder per codec in use, many receivers.
/// Thread-safe: called by the connections, the runner, the encoders and the host's clock.
///
/// Each call is one turn: under the lock the rules decide, and what they ask for is carried out
/// after the lock is released. So neither the host nor another session is called while this
/// session's lock is held, and the host may call a session under its own lock. Only messages to
/// viewers are sent under the lock, because a ClientLink neither blocks nor calls back, and so each
/// viewer receives them in the order of the turns. A strand would not do, because the runner and
/// the encoders need answers at once (RenderClient::requested, FrameSink::admit).
class LiveSession final : public std::enable_shared_from_this<LiveSession> {
 public:
  struct Start {
    SessionFacts facts;
    std::uint64_t placement = 0;
    std::shared_ptr<const diaphane::v1::Scene> scene;  ///< null: the volume's first preset
    std::uint64_t input_seq = 0;
    Canvas viewport{512, 512};
    std::string presenter;  ///< a participant; empty: the owner
    bool guest_slices = false;
    bool visitor = false;
  };
  /// The placement that a viewer's ticket belongs to.
  struct Opening {
    std::uint64_t placement = 0;
    bool visitor = false;
  };

  /// Creates a session. Calls `ended` once, without a lock, when the session ends on its own.
  LiveSession(SessionParts parts, Start start, std::function<void(const Error&)> ended);

  /// Loads the volume that the first scene needs. If that fails, the session ends with a fatal
  /// Problem. To be called once.
  void start();
  /// Adds a viewer and ends a previous connection of the same participant. Returns the number of
  /// the connection. Fails with kTooMany if the session is full.
  Result<std::uint64_t> attach(std::shared_ptr<ClientLink> link, const JoinRequest& join,
                               Opening opening);
  /// Handles a serialised ClientMessage. Ignores messages of connections that have ended.
  void receive(std::uint64_t connection, const std::string& bytes);
  void closed(std::uint64_t connection);
  /// Loads the volume again after its labels in the store have changed.
  void labels_changed();
  /// Ends the session with `why` as a fatal Problem for every viewer. Idempotent.
  void end(const Error& why);
  /// Ends a session that is no longer needed. Calls `ended` without notifying viewers.
  void dismiss();
  /// Returns a follower to the presenter's view after their own session, given by its id, gave up
  /// its slot. Returns false if no viewer uses it.
  bool take_camera_back(const std::string& session);
  /// To be called at least once per second with the number of sessions on this worker.
  void tick(std::size_t sessions);

  const SessionFacts& facts() const { return facts_; }
  SessionStatus status() const;
  /// Returns the state to save if Redis has an older one. mark_unsaved() makes it due again.
  std::optional<SavedSession> take_unsaved();
  void mark_unsaved();
  /// Returns nullopt until a scene is set and the owner is known.
  std::optional<RecoveryRecord> recovery_record() const;
  /// Returns the error of the current view after each pass.
  diaphane::v1::ErrorCurve error_curve() const;

 private:
  /// The runner's interface to the session (session_client.h).
  class Client;
  /// A codec in use: the slot of its encoder, and its link to this session.
  class Lane;
  using Lanes = std::vector<std::shared_ptr<Lane>>;

  // Called by the encoder of a lane.
  Admitted admit(const Lane& lane, const FrameInfo& frame);
  void coded(const Lane& lane, const FrameInfo& frame, CodedFrame data, double seconds);
  void dropped(const Lane& lane, const Error& why);

  /// Returns what is visible at a point of the shown picture (0 to 1). Must be called without the
  /// lock, because it takes milliseconds.
  std::optional<VisiblePoint> visible_at(double x, double y) const;
  /// Returns which places are behind matter in the shown picture. Must be called without the lock.
  std::vector<bool> hidden_marks(const std::vector<Double3>& places);
  void send_tiles();
  void tile_coded(const effect::CodeTile& of, std::optional<diaphane::v1::Still> coded);
  void keep_if_last(RenderedPicture& picture);

  /// One event (session_turn.h).
  class Turn;
  // Carry out what the rules ask for (session/effects.h). These require the lock:
  void apply(Effects effects);
  void apply(const Outcome& outcome, std::uint64_t connection);
  /// Applies an outcome that concerns the presenter.
  void apply_to_presenter(const Outcome& outcome);
  void carry_out(const effect::Send& effect);
  void carry_out(const effect::Configure& effect);
  void carry_out(const effect::BroadcastParticipants& effect);
  // These must be called without the lock:
  void carry_out(const effect::Warn& effect);
  void carry_out(const effect::WakeRunner& effect);
  void carry_out(const effect::LeaveRunner& effect);
  void carry_out(const effect::FindDepth& effect);
  void carry_out(const effect::FindPointer& effect);
  void carry_out(const effect::FindMarkSight& effect);
  void carry_out(const effect::FindGoodViews& effect);
  void carry_out(const effect::PokeEncoders& effect);
  void carry_out(const effect::LoadVoxels& effect);
  void carry_out(effect::CodeSlice& effect);
  void carry_out(effect::CodeTile& effect);
  void carry_out(effect::StartFile& effect);
  void carry_out(const effect::AcknowledgeFile& effect);
  void carry_out(const effect::StopFile& effect);
  void carry_out(const effect::OpenCamera& effect);
  void carry_out(const effect::EnterCamera& effect);
  void carry_out(const effect::ForwardToCamera& effect);
  void carry_out(const effect::FollowPresenter& effect);
  void carry_out(const effect::SilenceCamera& effect);
  void carry_out(const effect::DismissCamera& effect);

  /// Loads the voxels of the second scan, too, if there is one and they are missing.
  void voxels_ready(Result<VolumeCache::Handle> loaded);
  void second_voxels_ready(const Result<VolumeCache::Handle>& first,
                           const Result<VolumeCache::Handle>& second);
  void slices_ready(Result<VolumeCache::Handle> loaded);
  void slice_coded(SliceCoded coded);

  class FileLink;
  /// The work on the file that `files_` knows.
  struct File {
    std::uint64_t id = 0;
    std::shared_ptr<FileLink> link;
    std::shared_ptr<FileWork> work;
  };
  Result<File> begin_file(effect::StartFile& effect);
  FindHidden hidden_in(const DeviceVolume& volume) const;
  void on_file_message(std::uint64_t file, diaphane::v1::ServerMessage message, bool last);

  // All of these require the lock.
  void send(std::uint64_t connection, const diaphane::v1::ServerMessage& message);
  void send_config(std::uint64_t connection);
  void send_labels(const Receiver& receiver, const diaphane::v1::Labels& labels);
  void send_scene(std::uint64_t connection);
  void report_stats(std::size_t sessions, TimePoint now);
  void broadcast_participants();
  void finish_link(std::uint64_t connection, const Error& why, bool with_problem);
  void leave(std::uint64_t connection);
  Result<void> open_lane(diaphane::v1::Codec codec);
  void close_unused_lanes();
  bool in_use(const Lane& lane) const;
  void note(const Convergence::Measured& measured);

  /// Returns the volume's default look with the clip of the scene that it replaces, so that removed
  /// parts stay hidden. Precondition: the volume is loaded.
  std::shared_ptr<const diaphane::v1::Scene> first_look() const;

  // Must be called without the lock.
  void dispatch(std::uint64_t connection, const diaphane::v1::ClientMessage& message);
  /// Stops sending. The session keeps running until dismissed.
  void silence();
  /// Applies the presenter's settings (sessions for a free camera only), unless newer ones are
  /// known.
  void follow(const diaphane::v1::Scene& presenters, std::uint64_t number);
  std::shared_ptr<LiveSession> camera(const std::string& session) const;
  /// Returns the session whose picture a viewer sees, which may be that of their own camera.
  std::shared_ptr<LiveSession> seen_by(std::uint64_t connection);

  // Another phase of the scan, or showing or hiding the table, needs another copy of the volume,
  // which is loaded before the runner receives the scene (session_volume.cpp). Require the lock:
  VolumeKey copy_for(const diaphane::v1::Scene& scene) const;
  bool volume_fits();
  std::shared_ptr<const CoarseVolume> coarse_of_shown() const;
  /// Returns the second scan if the scene shows it.
  CoarseSecond coarse_second() const;
  diaphane::v1::SecondVolume second_for(ViewerKind viewer) const;
  void change_volume(const VolumeKey& copy, VolumeCache::Handle volume);
  void make_ready();
  /// Tells the viewers how many phases are loaded. Returns the next one that is missing, or
  /// `copy_`.
  VolumeKey report_phases();
  void send_phases(std::uint64_t connection);
  void send_phases_to_all();
  // Must be called without the lock:
  void volume_ready(Result<VolumeCache::Handle> volume);
  void show_first_volume(Result<VolumeCache::Handle> volume);
  void second_ready(VolumeCache::Handle first, Result<VolumeCache::Handle> second);
  /// Ends the session, because it cannot continue.
  void failed(const Error& why);
  Result<std::unique_ptr<FrameRenderer>> renderer_of(const Result<VolumeCache::Handle>& volume);
  void other_volume_ready(const VolumeKey& copy, Result<VolumeCache::Handle> loaded);
  void labels_ready(const VolumeKey& copy, Result<VolumeCache::Handle> loaded);
  void show_other_volume(const VolumeKey& copy, Result<VolumeCache::Handle> loaded);
  /// Loads all phases of the scan, one after the other, so that they can be played. Does nothing if
  /// they do not all fit on the device.
  void load_phases();
  void load_next_phase(std::uint32_t most);

  // Textures are decoded before the runner receives the scene that uses them
  // (session_textures.cpp). Require the lock:
  bool textures_ready();
  void publish_version();
  // Must be called without the lock:
  void textures_decoded(const std::shared_ptr<const diaphane::v1::Scene>& scene,
                        Result<std::shared_ptr<const PreparedTextures>> decoded);

  SessionParts parts_;
  const SessionFacts facts_;
  const TimePoint created_;
  std::atomic<bool> visitor_;
  const std::function<void(const Error&)> on_ended_;
  const std::shared_ptr<Client> client_;

  mutable std::mutex mutex_;
  SessionState state_;
  std::atomic<std::uint64_t> version_{0};
  std::map<std::uint64_t, std::shared_ptr<ClientLink>> links_;  // by connection
  Lanes lanes_;
  Effects pending_;  // to be carried out at the end of the turn
  Slices slices_;
  LosslessTiles tiles_;
  Convergence convergence_;
  Files files_;
  FreeCameras cameras_;
  Collaboration collaboration_;
  /// The newest answer to a MarkSightQuery, which is kept because all followers ask the same.
  struct MarkSight {
    std::uint64_t version = 0;
    std::vector<Double3> places;
    std::vector<bool> hidden;
  };
  MarkSight mark_sight_;
  std::map<std::string, std::shared_ptr<LiveSession>> camera_sessions_;  // by id
  std::uint64_t followed_ = 0;  // number of the presenter's newest settings
  std::shared_ptr<const DeviceVolume> volume_;
  std::shared_ptr<const DeviceVolume> second_;       ///< set before `volume_`; null: one scan
  std::shared_ptr<const HostVolume> second_voxels_;  ///< for slices; null until they are needed
  VolumeKey copy_;               ///< key of `volume_`, or of the one awaited first
  bool loading_other_ = false;   ///< another copy of the volume
  bool loading_phases_ = false;  ///< load_next_phase()
  diaphane::v1::VolumePhases phases_;
  std::optional<File> file_;
  std::vector<diaphane::v1::Preset> presets_;
  std::optional<diaphane::v1::Clip> fallback_clip_;  // clip of a scene that could not be shown
  /// The request whose textures and volume are loaded, which the runner sees.
  ViewRequest ready_;
  std::shared_ptr<const diaphane::v1::Scene> decoded_;  ///< scene whose textures are all decoded
  std::shared_ptr<const PreparedTextures> textures_;    // for `decoded_`
  bool decoding_ = false;
  std::uint64_t runner_handle_ = 0;
  std::atomic<bool> ended_{false};

  // Counters for Stats.
  TimePoint stats_since_{};
  double device_seconds_ = 0;
  std::uint64_t samples_since_ = 0;
  std::uint64_t dropped_samples_ = 0;
  std::uint64_t skipped_reported_ = 0;
  std::uint64_t skipped_before_ = 0;  // of lanes that are closed
};

}  // namespace diaphane::render
