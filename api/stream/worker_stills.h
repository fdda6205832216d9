#pragma once

#include <utility>

#include "api/shared/placement.h"
#include "api/shared/workers.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

/// Renders pictures with RenderStill. Prefers workers that have loaded the volume, then the least
/// loaded. Tries a second worker if the first is unavailable.
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
