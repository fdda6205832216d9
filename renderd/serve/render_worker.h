#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "common/clock.h"
#include "renderd/serve/assist_session.h"
#include "renderd/serve/homes.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/session_host.h"
#include "renderd/serve/still_service.h"
#include "renderd/session/histogram.h"
#include "volume/node_cache.h"

namespace diaphane::render {

/// The devices of this process with their sessions, runners, encoders and volumes, without the
/// network.
class RenderWorker {
 public:
  struct Options {
    std::string volume_dir;
    std::uint64_t volume_bytes = std::uint64_t{4} << 30;  ///< limit for loaded volumes
    std::shared_ptr<volume::NodeCache> copies;            ///< on a disk of this node; may be null
    unsigned encoder_threads = 1;
    std::uint32_t still_samples = StillService::kMostSamples;  ///< maximum per pixel
    SessionHost::Options host;
    Runner::Options runner;  ///< without what the engine reports about its device
    PolicyKind policy = PolicyKind::kMarginalGain;
  };

  RenderWorker(Options options, std::unique_ptr<Engine> engine, Metrics& metrics,
               const Clock& clock);
  ~RenderWorker();

  /// Ends all sessions and stills, and stops rendering. Idempotent.
  void stop();

  Engine& engine() { return *engine_; }
  SessionHost& host() { return *host_; }
  StillService& stills() { return *stills_; }
  AssistHost& assists() { return *assists_; }
  VolumeCache& volumes() { return *volumes_; }
  Homes& homes() { return *homes_; }

 private:
  SessionHost::Options with_reclaim(SessionHost::Options options);
  void slow_down_decoding();
  /// Drops copies of volumes that are no longer in the store, and ends their sessions, every
  /// second.
  void watch_store(const std::stop_token& stop);

  Metrics& metrics_;
  const std::shared_ptr<volume::NodeCache> copies_;
  // Each may call those before it. The destructor defines the order of destruction.
  std::unique_ptr<Engine> engine_;
  VolumeStatsCache stats_;
  std::unique_ptr<Homes> homes_;
  std::unique_ptr<EncodePool> encoders_;
  std::unique_ptr<VolumeCache> volumes_;
  std::unique_ptr<EncodePool> slicers_;
  std::unique_ptr<EncodePool> textures_;  ///< decodes textures of sessions
  std::unique_ptr<VolumeCache> voxels_;   ///< volumes in host memory for viewers of slices
  std::unique_ptr<SessionHost> host_;
  std::unique_ptr<StillService> stills_;
  std::unique_ptr<AssistHost> assists_;
  std::jthread watching_;
};

}  // namespace diaphane::render
