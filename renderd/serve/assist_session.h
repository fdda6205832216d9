#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <set>

#include "api/proto/worker.pb.h"
#include "renderd/composite/assist_renderer.h"
#include "renderd/serve/homes.h"
#include "renderd/session/volume_cache.h"

namespace diaphane::render {

/// The connection of another worker. The calls neither block nor call back.
class AssistLink {
 public:
  virtual ~AssistLink() = default;
  virtual void send(diaphane::v1::AssistReply reply) = 0;
  virtual void finish(const Error& why) = 0;
};

/// Sessions that help with the pictures of other workers. Each is one more session of the runner,
/// and its pictures are parts of films. Thread-safe.
class AssistHost {
 public:
  struct Options {
    std::size_t most = 16;  ///< concurrent sessions
    /// Loaded volumes may have this many bytes when a session with spare time opens, so that it
    /// takes no memory that this worker's own sessions are likely to need.
    std::uint64_t spare_bytes = 0;
  };

  AssistHost(Options options, Homes& homes, VolumeCache& volumes)
      : options_(options), homes_(homes), volumes_(volumes) {}

  class Session;
  /// Opens a session. Fails with kTooMany if no more fit, and with kUnavailable while draining.
  Result<std::shared_ptr<Session>> open(std::shared_ptr<AssistLink> link);
  /// Ends all sessions and refuses new ones.
  void end_all();
  std::size_t used() const;
  /// Returns the device time spent on other workers' pictures since the start, apart from spare
  /// time, which does not count as load either (Runner::busy_seconds).
  double lent_seconds() const { return lent_seconds_; }
  /// Ends the sessions with spare time, so that their volumes can be dropped. Returns whether there
  /// were any.
  bool end_spare();

 private:
  void forget(const std::shared_ptr<Session>& session);
  /// Decides whether a session that has connected may begin. One that is needed ends those with
  /// spare time if there is no room for it.
  Result<void> admit(bool spare);

  const Options options_;
  Homes& homes_;
  VolumeCache& volumes_;
  mutable std::mutex mutex_;
  std::set<std::shared_ptr<Session>> sessions_;
  bool refusing_ = false;
  std::atomic<double> lent_seconds_{0};
};

class AssistHost::Session final : public RenderClient,
                                  public std::enable_shared_from_this<AssistHost::Session> {
 public:
  Session(AssistHost& host, std::shared_ptr<AssistLink> link)
      : host_(host), home_(host.homes_.take()), link_(std::move(link)) {}

  /// Handles a message. An invalid one ends the connection with kInvalid.
  void receive(const diaphane::v1::AssistRequest& request);
  /// To be called when the connection has ended. Idempotent.
  void closed();
  void end(const Error& why);

  // Implementation of RenderClient:
  bool of_another_worker() const override { return true; }
  bool with_spare_time() const override { return spare_; }
  ViewRequest requested() override;
  std::uint64_t version() const noexcept override { return version_; }
  void began(std::uint64_t, const ViewRequest&) override {}
  void refused(const ViewRequest&, const Error&) override {}
  void rendered(const Batch& batch) override {
    if (!spare_) host_.lent_seconds_ += batch.seconds;
    send_part();
  }
  void picture(RenderedPicture) override { send_part(); }
  void failed(const Error& why) override { end(why); }

 private:
  Result<void> open(const diaphane::v1::AssistOpen& open);
  Result<void> take(const diaphane::v1::AssistTask& task);
  void volume_ready(const diaphane::v1::AssistOpen& open, Result<VolumeCache::Handle> volume);
  void send_part();

  AssistHost& host_;
  const std::shared_ptr<const Home> home_;
  const std::shared_ptr<AssistDesk> desk_ = std::make_shared<AssistDesk>();
  std::atomic<std::uint64_t> version_{0};
  std::mutex mutex_;
  std::shared_ptr<AssistLink> link_;  ///< null: closed
  bool opened_ = false;
  std::atomic<bool> spare_{false};
  std::uint64_t handle_ = 0;  ///< handle in the runner; 0: not added yet
};

}  // namespace diaphane::render
