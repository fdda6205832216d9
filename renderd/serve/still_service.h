#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "api/proto/worker.pb.h"
#include "common/clock.h"
#include "renderd/encode/encode_pool.h"
#include "renderd/serve/homes.h"
#include "renderd/serve/metrics.h"
#include "renderd/session/volume_cache.h"
#include "renderd/session/volume_stats.h"

namespace diaphane::render {

/// Renders pictures without a session, such as thumbnails, with a limited share of the device
/// (still_share). At most `kPending` can wait.
class StillService {
 public:
  using Done = std::function<void(Result<diaphane::v1::StillReply>)>;
  static constexpr int kPending = 16;
  static constexpr std::uint32_t kMostSamples = 4096;

  /// Limits every picture to `most_samples` samples per pixel, whatever is requested.
  StillService(Homes& homes, EncodePool& encoders, VolumeCache& volumes,
               const VolumeStatsCache& stats, Metrics& metrics, const Clock& clock,
               std::uint32_t most_samples = kMostSamples)
      : homes_(homes),
        encoders_(encoders),
        volumes_(volumes),
        stats_(stats),
        metrics_(metrics),
        clock_(clock),
        most_samples_(most_samples) {}

  /// Renders a picture and calls `done` once, from any thread, possibly before this returns. Fails
  /// with kTooMany if the queue is full. `cancelled` is set when the caller no longer waits.
  void render(const diaphane::v1::StillRequest& request,
              std::shared_ptr<const std::atomic<bool>> cancelled, Done done);

 private:
  struct Order;
  void begin(std::shared_ptr<Order> order, Result<VolumeCache::Handle> volume);

  Homes& homes_;
  EncodePool& encoders_;
  VolumeCache& volumes_;
  const VolumeStatsCache& stats_;
  Metrics& metrics_;
  const Clock& clock_;
  const std::uint32_t most_samples_;
  // The number of waiting stills, shared with the orders, because the last may outlive this object.
  const std::shared_ptr<std::atomic<int>> pending_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace diaphane::render
