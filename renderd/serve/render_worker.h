#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "common/clock.h"
#include "renderd/serve/assist_session.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/session_host.h"
#include "renderd/serve/still_service.h"
#include "renderd/session/histogram.h"
#include "volume/node_cache.h"

namespace diaphane::render {

/// One device with everything around it, but for the wires: sessions, runner, encoders, volumes.
class RenderWorker {
 public:
  struct Options {
    std::string volume_dir;
    std::uint64_t volume_bytes = std::uint64_t{4} << 30;  ///< bound of loaded volumes
    std::shared_ptr<volume::NodeCache> copies;            ///< on a disk of this node, if any
    unsigned encoder_threads = 1;
    SessionHost::Options host;
    Runner::Options runner;  ///< but for what the engine says of its device
    PolicyKind policy = PolicyKind::kMarginalGain;
  };

  RenderWorker(Options options, std::unique_ptr<Engine> engine, Metrics& metrics,
               const Clock& clock);
  ~RenderWorker();

  /// Ends all sessions and stills; after it nothing is rendered. Idempotent.
  void stop();

  Engine& engine() { return *engine_; }
  SessionHost& host() { return *host_; }
  StillService& stills() { return *stills_; }
  AssistHost& assists() { return *assists_; }
  VolumeCache& volumes() { return *volumes_; }
  Runner& runner() { return *runner_; }

 private:
  void slow_down_decoding();
  /// Each second: copies of volumes that the store has no more are let go, their sessions ended.
  void watch_store(const std::stop_token& stop);

  Metrics& metrics_;
  const std::shared_ptr<volume::NodeCache> copies_;
  // Each may call into those before it; the destructor says in which order they end.
  std::unique_ptr<Engine> engine_;
  KeptFacts facts_;
  std::unique_ptr<Runner> runner_;
  std::unique_ptr<EncodePool> encoders_;
  std::unique_ptr<VolumeCache> volumes_;
  std::unique_ptr<EncodePool> slicers_;
  std::unique_ptr<EncodePool> textures_;  ///< decodes those of sessions
  std::unique_ptr<VolumeCache> voxels_;   ///< in the machine's memory, of those who see slices
  std::unique_ptr<SessionHost> host_;
  std::unique_ptr<StillService> stills_;
  std::unique_ptr<AssistHost> assists_;
  std::jthread watching_;
};

}  // namespace diaphane::render
