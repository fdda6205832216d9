#pragma once

#include <utility>

#include "api/shared/placement.h"
#include "api/shared/workers.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

/// Renders thumbnails with RenderStill on a live worker: one that has loaded the volume, otherwise
/// the least loaded. Asks the next one if the call fails.
class WorkerStills final : public Stills {
 public:
  explicit WorkerStills(Workers& workers, wire::InnerTls tls = {})
      : workers_(workers), channels_(std::move(tls)) {}
  Result<std::string> render(const StillRequest& request) override;

 private:
  Workers& workers_;
  WorkerChannels channels_;
};

}  // namespace diaphane::api::stream
