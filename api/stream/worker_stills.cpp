#include "api/stream/worker_stills.h"

#include <algorithm>
#include <chrono>
#include <tuple>

#include "api/proto/worker.grpc.pb.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api::stream {
namespace {

namespace v1 = diaphane::v1;

constexpr std::chrono::seconds kLongest{20};
constexpr std::chrono::seconds kLongestInBackground{60};
constexpr std::size_t kMostTries = 2;

Error error_of(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::NOT_FOUND:
      return {ErrorCode::kNotFound, "The renderer does not have this scan.", {}};
    case grpc::StatusCode::INVALID_ARGUMENT:
      return {ErrorCode::kInvalid, "Image not found.", {}};
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return {ErrorCode::kUnavailable, "The renderer is busy. Please try again in a moment.", {}};
    default:
      return {
          ErrorCode::kUnavailable, "No renderer is responding. Please try again in a moment.", {}};
  }
}

}  // namespace

Result<std::string> WorkerStills::render(const StillRequest& request) {
  const auto deadline =
      std::chrono::system_clock::now() + (request.background ? kLongestInBackground : kLongest);
  Result<std::vector<WorkerInfo>> workers = workers_.alive();
  DIAPHANE_TRY(workers);
  std::erase_if(*workers, [](const WorkerInfo& one) { return one.draining; });
  std::sort(workers->begin(), workers->end(), [&](const WorkerInfo& a, const WorkerInfo& b) {
    const auto rank = [&](const WorkerInfo& one) {
      const bool has_it = std::find(one.volumes.begin(), one.volumes.end(), request.data_set_id) !=
                          one.volumes.end();
      return std::tuple(!has_it, static_cast<double>(one.used) / std::max(1u, one.slots), one.id);
    };
    return rank(a) < rank(b);
  });

  channels_.drop_unused();
  v1::StillRequest still;
  still.set_volume_id(request.data_set_id);
  if (request.scene.empty()) {
    still.set_preset(request.preset);
  } else if (!still.mutable_scene()->ParseFromString(request.scene)) {
    return fail(ErrorCode::kInvalid, "This is not a valid scene.");
  }
  still.set_width(request.width);
  still.set_height(request.height);
  still.set_samples(request.samples);
  still.set_error(request.error);
  still.set_background(request.background);
  Error last{ErrorCode::kUnavailable, "No renderer is running. Please try again in a moment.", {}};
  for (std::size_t i = 0; i < std::min(workers->size(), kMostTries); ++i) {
    const WorkerInfo& worker = (*workers)[i];
    const auto stub = v1::RenderWorker::NewStub(channels_.to(worker.address, worker.incarnation));
    grpc::ClientContext context;
    context.set_deadline(deadline);
    v1::StillReply reply;
    const grpc::Status status = stub->RenderStill(&context, still, &reply);
    if (status.ok()) return std::move(*reply.mutable_jpeg());
    last = error_of(status);
    log::warning("still_failed",
                 {{"worker", worker.id}, {"status", static_cast<int>(status.error_code())}});
    if (status.error_code() == grpc::StatusCode::PERMISSION_DENIED) {
      log::error("still_refused", {{"message", status.error_message()}});  // about certificates
    }
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE) break;
  }
  return tl::unexpected(std::move(last));
}

}  // namespace diaphane::api::stream
