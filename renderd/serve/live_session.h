#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/clock.h"
#include "renderd/encode/encode_lane.h"
#include "renderd/schedule/runner.h"
#include "renderd/serve/metrics.h"
#include "renderd/session/state.h"

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

/// What a session needs of the process; all outlive it.
struct SessionParts {
  Engine& engine;
  Runner& runner;
  EncodePool& encoders;
  Metrics& metrics;
  const Clock& clock;
  std::function<std::size_t()> session_count;
  bool mark_frames = false;  ///< for a bench: input_seq in the pixels (encode/frame_mark.h)
};

/// One session: joins the pure state machine to the runner, the encoder and the connection.
/// Thread-safe: called by the connection, the runner, an encoder and the host's clock.
class LiveSession final : public RenderClient,
                          public FrameSink,
                          public std::enable_shared_from_this<LiveSession> {
 public:
  struct Start {
    std::string id;
    std::string volume_id;
    std::uint64_t placement = 0;
    std::shared_ptr<const diaphane::v1::Scene> scene;  ///< empty: the volume's first preset
    std::uint64_t input_seq = 0;
    Canvas viewport{512, 512};
  };
  /// What a lost worker's successor needs, as it goes to Redis.
  struct Saved {
    std::string id;
    std::uint64_t placement = 0;
    std::string scene;  ///< serialised
    std::uint64_t input_seq = 0;
    Canvas viewport;
  };

  /// `ended` is called once, without a lock held, when the session has ended by itself.
  LiveSession(SessionParts parts, Start start, std::function<void()> ended);

  /// A connection takes the session over; the one before is ended. Returns its number.
  std::uint64_t attach(std::shared_ptr<ClientLink> link, std::uint64_t placement);
  /// The volume came, or did not: then the session ends with a fatal Problem.
  void volume_ready(Result<std::shared_ptr<const DeviceVolume>> volume);
  /// A serialised ClientMessage. Of an older connection it is ignored.
  void receive(std::uint64_t connection, const std::string& bytes);
  void closed(std::uint64_t connection);
  /// Ends it: the viewer gets `why` as a fatal Problem. Idempotent.
  void end(const Error& why);
  /// Once or more a second.
  void tick();

  const std::string& id() const { return id_; }
  const std::string& volume_id() const { return volume_id_; }
  std::uint64_t placement() const;
  /// How long nobody has been attached; nothing while somebody is.
  std::optional<std::chrono::steady_clock::duration> abandoned_for() const;
  /// The scene, when Redis has an older one; asks for it again with `mark_unsaved`.
  std::optional<Saved> take_unsaved();
  void mark_unsaved();

  // RenderClient, FrameSink
  Wanted wanted() override;
  std::uint64_t version() const noexcept override;
  void began(std::uint64_t epoch, const Wanted& wanted) override;
  void refused(const Wanted& wanted, const Error& why) override;
  void rendered(const Batch& batch) override;
  void picture(RenderedPicture picture) override;
  void failed(const Error& why) override;
  Admission admit(const FrameInfo& frame) override;
  void coded(const FrameInfo& frame, Canvas size, CodedFrame data, double seconds) override;
  void dropped(const FrameInfo& frame, const Error& why) override;

 private:
  void send(const diaphane::v1::ServerMessage& message);  // under the lock
  void send_config();                                     // under the lock
  void carry_out(const Outcome& outcome, std::unique_lock<std::mutex>& lock);
  void finish_link(const Error& why, bool with_problem);  // under the lock

  SessionParts parts_;
  const std::string id_;
  const std::string volume_id_;
  const std::function<void()> on_ended_;

  mutable std::mutex mutex_;
  SessionState state_;
  std::atomic<std::uint64_t> version_{0};
  std::shared_ptr<ClientLink> link_;
  std::uint64_t connection_ = 0;
  std::shared_ptr<EncodeLane> lane_;
  std::shared_ptr<const DeviceVolume> volume_;
  std::vector<diaphane::v1::Preset> presets_;
  std::uint64_t runner_handle_ = 0;
  bool ended_ = false;

  // For Stats.
  TimePoint stats_since_{};
  std::uint64_t samples_since_ = 0;
  std::uint64_t dropped_samples_ = 0;
  std::uint64_t skipped_told_ = 0;
};

}  // namespace diaphane::render
