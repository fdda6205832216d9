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
#include "renderd/encode/tile_source.h"
#include "renderd/scene/light_textures.h"
#include "renderd/schedule/runner.h"
#include "renderd/serve/file_work.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/spent_time.h"
#include "renderd/session/host_volume.h"
#include "renderd/session/pictures.h"
#include "renderd/session/slice_wishes.h"
#include "renderd/session/volume_cache.h"
#include "renderd/session/volume_facts.h"

namespace diaphane::render {

/// One viewer's connection, as the session needs it. Neither call blocks or calls back.
class ClientLink {
 public:
  virtual ~ClientLink() = default;
  /// A serialised ServerMessage.
  virtual void send(std::string server_message) = 0;
  /// Ends the connection after what was sent; `why` becomes its status.
  virtual void finish(const Error& why) = 0;
};

class LiveSession;

/// A follower's own camera: what his session begins with.
struct Branch {
  std::string participant;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas viewport;
  std::string link;                    ///< that let him in; empty: the owner
  std::weak_ptr<LiveSession> group{};  ///< whose scene it follows
};

/// Where slices are read and coded, apart from pictures: a slice must not wait for one, nor the
/// other way round.
struct SliceParts {
  VolumeCache& voxels;  ///< of HostVolume
  EncodePool& pool;     ///< each viewer has one slice in it at most
};

/// What a session needs of the process; all outlive it.
struct SessionParts {
  Engine& engine;
  Runner& runner;
  EncodePool& encoders;
  Metrics& metrics;
  const Clock& clock;
  std::function<std::size_t()> session_count;
  /// A session for one follower's own camera, in a slot of its own. kTooMany: none is free.
  std::function<Result<std::shared_ptr<LiveSession>>(const LiveSession& group, const Branch&)>
      branch;
  bool mark_frames = false;  ///< for a bench: input_seq in the pixels (encode/frame_mark.h)
  SpentTime& spent;
  const KeptFacts& facts;
  SliceParts slices;
  std::atomic<int>& files;  ///< that are being made on this worker
  /// Decodes textures, one at a time, beside everything else: that takes up to a second.
  EncodePool& textures;
};

/// One session: joins the pure state machine to the runner, the encoders and the connections of all
/// who look at it. One render, one encoder for each codec in use, many receivers. Thread-safe:
/// called by the connections, the runner, the encoders and the host's clock.
class LiveSession final : public RenderClient, public std::enable_shared_from_this<LiveSession> {
 public:
  struct Start {
    std::string id;
    std::string volume_id;
    std::uint64_t placement = 0;
    std::shared_ptr<const diaphane::v1::Scene> scene;  ///< empty: the volume's first preset
    std::uint64_t input_seq = 0;
    Canvas viewport{512, 512};
    std::string presenter;     ///< participant; empty: the owner
    std::string user_id;       ///< whose session it is
    std::string charged_to;    ///< whose render time it takes: user; empty: nobody's
    bool camera_only = false;  ///< of a follower with a camera of his own
    bool guest_slices = false;
    bool visitor = false;   ///< within the visitors' share: of somebody without an account
    std::string link = {};  ///< of a guest's own camera: the link that let him in
    std::weak_ptr<LiveSession> group = {};  ///< of a follower's own camera
  };
  /// What a lost worker's successor needs, as it goes to Redis.
  struct Saved {
    std::string id;
    std::uint64_t placement = 0;
    std::string scene;  ///< serialised
    std::uint64_t input_seq = 0;
    Canvas viewport;
    std::string presenter;  ///< participant
    bool guest_slices = false;
  };
  /// What Redis needs beyond that when it has lost everything.
  struct Lost {
    Saved saved;
    std::string user_id;
    std::string volume_id;
    std::vector<std::string> links;  ///< that guests came by
    bool visitor = false;
  };

  /// `ended` is called once, without a lock held, when the session has ended by itself.
  LiveSession(SessionParts parts, Start start, std::function<void(const Error&)> ended);

  /// One more viewer; a connection that the same participant had before is ended. Returns its
  /// number, or kTooMany.
  Result<std::uint64_t> attach(std::shared_ptr<ClientLink> link, const Arrival& arrival,
                               std::uint64_t placement);
  /// The volume came, or did not: then the session ends with a fatal Problem.
  void volume_ready(Result<std::shared_ptr<const DeviceVolume>> volume);
  /// A serialised ClientMessage. Of a connection that has ended it is ignored.
  void receive(std::uint64_t connection, const std::string& bytes);
  void closed(std::uint64_t connection);
  /// Ends it: every viewer gets `why` as a fatal Problem. Idempotent.
  void end(const Error& why);
  /// Ended because nobody needs it; nobody is told but `ended`.
  void dismiss();
  /// Nobody hears of it any more; it goes on until it is dismissed.
  void silence();
  /// A follower's own session, by its id, gave up its slot: he follows the presenter again. False:
  /// nobody here looks at it.
  bool take_camera_back(const std::string& branch);
  bool has_ended() const;
  /// Of a follower's own session: the presenter's settings.
  void follow(const diaphane::v1::Scene& presenters);
  /// Once or more a second.
  void tick();

  const std::string& id() const { return id_; }
  const std::string& volume_id() const { return volume_id_; }
  const std::string& charged_to() const { return charged_to_; }
  bool camera_only() const { return camera_only_; }
  const std::string& link() const { return link_; }
  std::shared_ptr<LiveSession> group() const { return group_.lock(); }
  bool visitor() const { return visitor_; }
  /// Whoever opens it anew may have an account, or no longer.
  void set_visitor(bool visitor) { visitor_ = visitor; }
  /// How long it has held its slot.
  std::chrono::steady_clock::duration age() const { return parts_.clock.now() - created_; }
  std::uint64_t placement() const;
  /// That its samples took of the device.
  double device_seconds() const;
  /// How long nobody has been attached; nothing while somebody is.
  std::optional<std::chrono::steady_clock::duration> abandoned_for() const;
  /// The scene, when Redis has an older one; asks for it again with `mark_unsaved`.
  std::optional<Saved> take_unsaved();
  void mark_unsaved();
  /// Nothing before it has a scene, or when nobody said whose it is.
  std::optional<Lost> lost() const;

  // RenderClient
  bool of_visitor() const override { return visitor_; }
  Wanted wanted() override;
  std::uint64_t version() const noexcept override;
  void began(std::uint64_t epoch, const Wanted& wanted) override;
  void refused(const Wanted& wanted, const Error& why) override;
  void rendered(const Batch& batch) override;
  void picture(RenderedPicture picture) override;
  void kernel(const KernelReport& report) override;
  void failed(const Error& why) override;

 private:
  /// A codec in use: its encoder's slot, and what ties the slot to this session.
  class Lane;
  using Lanes = std::vector<std::shared_ptr<Lane>>;

  // What an encoder asks and tells, of the lane that it codes for.
  Admitted admit(const Lane& lane, const FrameInfo& frame);
  void coded(const Lane& lane, const FrameInfo& frame, CodedFrame data, double seconds);
  void dropped(const Lane& lane, const Error& why);

  /// The lossless end: sends what is coded and has room, and has coded what comes next.
  void send_tiles();
  void keep_if_last(RenderedPicture& picture);

  // Exact slices: asked for, their voxels loaded when the first is, coded one by one.
  void receive_slices(std::uint64_t connection, const diaphane::v1::SlicesWanted& wanted);
  void voxels_ready(Result<VolumeCache::Handle> loaded);
  void send_slices(std::uint64_t connection);
  /// A slice on its way, and what of it was shown: null for the whole.
  struct SliceOrder {
    SliceDue due;
    std::optional<diaphane::v1::Clip> clip;
  };
  void slice_coded(std::uint64_t connection, const SliceOrder& order, Result<std::string> coded);
  /// Under the lock. Nothing: this viewer gets none.
  std::optional<SliceOrder> order_of(const Receiver& receiver, const SliceDue& due) const;

  // Files to be taken away (docs/adr/0031).
  class FileLink;
  void receive_file(std::uint64_t connection, const diaphane::v1::ClientMessage& message);
  Result<std::shared_ptr<FileWork>> begin_file(std::uint64_t connection,
                                               const diaphane::v1::FileWanted& wanted);
  void send_of_file(const FileLink& link, const diaphane::v1::ServerMessage& message, bool last);
  // Under the lock.
  void give_up_file();
  void give_up_file_of(std::uint64_t connection);

  // All of these under the lock.
  void send(std::uint64_t connection, const diaphane::v1::ServerMessage& message);
  void send_config(std::uint64_t connection);
  void send_problem(std::uint64_t connection, const Error& why);
  void load_voxels();
  void send_tile(const TileDue& due, const CodedTile& coded, const Departure& departure);
  /// A frame or a tile, and what is to be told after it.
  void send_departing(const Departure& departure, const diaphane::v1::ServerMessage& message);
  void send_look(std::uint64_t connection);
  void tell_audience();
  void finish_link(std::uint64_t connection, const Error& why, bool with_problem);
  void leave(std::uint64_t connection);
  Result<void> open_lane(diaphane::v1::Codec codec);
  void close_unused_lanes();
  bool in_use(const Lane& lane) const;

  /// The volume's own look; what the scene in its place had cut away stays cut away. Precondition:
  /// the volume is there.
  std::shared_ptr<const diaphane::v1::Scene> first_look() const;
  void lead_branches();
  void tell_stale_slices();
  std::shared_ptr<LiveSession> take_branch(std::uint64_t connection);

  // Without it.
  /// `why` is told to whose own camera was taken back.
  void change_camera(std::uint64_t connection, bool own, const Error* why = nullptr);
  void answer(const diaphane::v1::DepthQuery& query, std::uint64_t connection);
  void carry_out(const Outcome& outcome, std::uint64_t connection,
                 std::unique_lock<std::mutex>& lock);
  Lanes lanes() const;
  Saved saved() const;  // under the lock

  // Textures are decoded before the runner hears of the scene that has them (session_textures.cpp).
  // Under the lock:
  bool textures_ready();
  void publish_version();
  // Without it:
  void textures_decoded(const std::shared_ptr<const diaphane::v1::Scene>& scene,
                        Result<std::shared_ptr<const PreparedTextures>> decoded);

  SessionParts parts_;
  const std::string id_;
  const std::string volume_id_;
  const std::string user_id_;
  const std::string charged_to_;
  const std::string link_;
  const bool camera_only_;
  const std::weak_ptr<LiveSession> group_;
  const TimePoint created_;
  std::atomic<bool> visitor_;
  const std::function<void(const Error&)> on_ended_;

  mutable std::mutex mutex_;
  SessionState state_;
  std::atomic<std::uint64_t> version_{0};
  std::map<std::uint64_t, std::shared_ptr<ClientLink>> links_;  // by connection
  Lanes lanes_;
  struct OwnCamera {
    std::shared_ptr<LiveSession> session;
    std::uint64_t connection = 0;  // there
  };
  // By connection here. Its lock may be taken under ours, never ours under its.
  std::map<std::uint64_t, OwnCamera> branches_;
  std::shared_ptr<const diaphane::v1::Scene> led_;     // the scene that they follow
  std::shared_ptr<const diaphane::v1::Scene> sliced_;  // by whose clip slices are clipped
  /// The converged picture of this epoch, once there is one.
  struct Last {
    FrameInfo info;
    std::shared_ptr<TileSource> tiles;
  };
  std::optional<Last> last_;
  std::shared_ptr<const DeviceVolume> volume_;
  std::optional<SliceStacks> stacks_;         // once the volume is there
  std::shared_ptr<const HostVolume> voxels_;  // while somebody is here who wanted slices
  bool loading_voxels_ = false;
  /// The one that is being made or sent, for the connection that asked.
  struct File {
    std::uint64_t connection = 0;
    std::shared_ptr<FileLink> link;
    std::shared_ptr<FileWork> work;
  };
  std::optional<File> file_;
  std::vector<diaphane::v1::Scene> key_views_;
  std::vector<diaphane::v1::Preset> presets_;
  std::optional<diaphane::v1::Clip> fallback_clip_;  // of a scene that could not be shown
  /// What is wanted with all its textures decoded: what the runner is told.
  Wanted ready_;
  std::shared_ptr<const PreparedTextures> textures_;  // of `ready_`
  bool decoding_ = false;
  std::uint64_t runner_handle_ = 0;
  bool ended_ = false;

  // For Stats.
  TimePoint stats_since_{};
  double device_seconds_ = 0;
  std::uint64_t samples_since_ = 0;
  std::uint64_t dropped_samples_ = 0;
  std::uint64_t skipped_told_ = 0;
  std::uint64_t skipped_before_ = 0;  // in lanes that are closed
};

}  // namespace diaphane::render
