#include "api/stream/worker_error_curves.h"

#include <algorithm>
#include <chrono>

#include "api/proto/worker.grpc.pb.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api::stream {
namespace {

namespace v1 = diaphane::v1;

constexpr std::chrono::seconds kLongestCurve{5};

ErrorCurve from_proto(const v1::ErrorCurve& curve) {
  ErrorCurve out;
  out.epoch = curve.epoch();
  for (const auto& point : curve.points()) {
    out.points.push_back({point.samples(), point.seconds(), point.error()});
  }
  return out;
}

}  // namespace

Result<ErrorCurve> WorkerErrorCurves::find(const std::string& worker_id,
                                           const std::string& session_id) {
  const Result<std::vector<WorkerInfo>> workers = workers_.alive();
  DIAPHANE_TRY(workers);
  const auto worker = std::find_if(workers->begin(), workers->end(),
                                   [&](const WorkerInfo& one) { return one.id == worker_id; });
  if (worker == workers->end()) {
    return fail(ErrorCode::kUnavailable, "The renderer of this session is not running.");
  }
  channels_.drop_unused();
  const auto stub = v1::RenderWorker::NewStub(channels_.to(worker->address, worker->incarnation));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kLongestCurve);
  v1::ErrorCurveRequest request;
  request.set_session_id(session_id);
  v1::ErrorCurve reply;
  const grpc::Status status = stub->GetErrorCurve(&context, request, &reply);
  if (status.ok()) return from_proto(reply);
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) {
    return fail(ErrorCode::kNotFound, "The renderer does not have this session.");
  }
  log::warning("error_curve_failed",
               {{"worker", worker->id}, {"status", static_cast<int>(status.error_code())}});
  return fail(ErrorCode::kUnavailable,
              "The renderer is not responding. Please try again in a moment.");
}

}  // namespace diaphane::api::stream
