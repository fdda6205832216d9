#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "api/proto/worker.grpc.pb.h"
#include "renderd/serve/assist_session.h"
#include "renderd/serve/reply_queue.h"

// One Assist call on the serving side. To be included only by grpc_server.cpp.

namespace diaphane::render {

/// The writing side of one Assist call. A part counts as sent when the other side acknowledges it,
/// so the queue holds the bands of at most one part.
class AssistStream final : public AssistLink,
                           public ReplyQueue<v1::AssistRequest, v1::AssistReply> {
 public:
  using ReplyQueue::ReplyQueue;

  void send(v1::AssistReply reply) override {
    const std::lock_guard lock(mutex_);
    if (open()) push(std::move(reply));
  }
  void finish(const Error& why) override {
    const auto code = why.code == ErrorCode::kInvalid       ? grpc::StatusCode::INVALID_ARGUMENT
                      : why.code == ErrorCode::kNotFound    ? grpc::StatusCode::NOT_FOUND
                      : why.code == ErrorCode::kUnavailable ? grpc::StatusCode::UNAVAILABLE
                                                            : grpc::StatusCode::RESOURCE_EXHAUSTED;
    finish(grpc::Status(code, why.message));
  }
  void finish(grpc::Status status) {
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    queue_.clear();
    end(std::move(status));
  }
};

/// One Assist call. Deletes itself when gRPC is done with it. If `host` is null, it is refused.
class AssistReactor final : public AssistStream::Reactor {
 public:
  explicit AssistReactor(AssistHost* host) : stream_(std::make_shared<AssistStream>(this)) {
    Result<std::shared_ptr<AssistHost::Session>> opened =
        fail(ErrorCode::kUnavailable, "This worker does not assist other workers.");
    if (host != nullptr) opened = host->open(stream_);
    if (opened) {
      session_ = std::move(*opened);
    } else {
      stream_->finish(opened.error());
    }
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      if (session_) session_->closed();
      stream_->finish(grpc::Status::OK);
      return;
    }
    if (session_) session_->receive(request_);
    StartRead(&request_);
  }
  void OnWriteDone(bool ok) override { stream_->written(ok); }
  void OnDone() override {
    stream_->over();
    delete this;
  }

 private:
  std::shared_ptr<AssistStream> stream_;
  v1::AssistRequest request_;
  std::shared_ptr<AssistHost::Session> session_;
};

}  // namespace diaphane::render
