#pragma once

#include <utility>

#include "api/shared/error_curves.h"
#include "api/shared/workers.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

/// Gets error curves from the workers of the sessions (GetErrorCurve).
class WorkerErrorCurves final : public ErrorCurves {
 public:
  explicit WorkerErrorCurves(Workers& workers, wire::InnerTls tls = {})
      : workers_(workers), channels_(std::move(tls)) {}
  Result<ErrorCurve> find(const std::string& worker_id, const std::string& session_id) override;

 private:
  Workers& workers_;
  WorkerChannels channels_;
};

}  // namespace diaphane::api::stream
