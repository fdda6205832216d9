#pragma once

#include <utility>

#include "api/service/placement.h"
#include "api/service/workers.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

/// Thumbnails by RenderStill of a worker that lives: one that has the volume, else the least used.
/// When it breaks off, the next is asked.
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
