#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "api/proto/worker.grpc.pb.h"
#include "renderd/serve/assist_session.h"

// One Assist call on the serving side. To be included only by grpc_server.cpp.

namespace diaphane::render {

/// Writes one message at a time, then the status. It outlives the call, because the session may
/// hold it slightly longer. A part counts as sent when the other side acknowledges it, so the queue
/// holds the bands of at most one part.
class AssistStream final : public AssistLink {
 public:
  using Reactor = grpc::ServerBidiReactor<v1::AssistRequest, v1::AssistReply>;

  explicit AssistStream(Reactor* reactor) : reactor_(reactor) {}

  void send(v1::AssistReply reply) override {
    const std::lock_guard lock(mutex_);
    if (!reactor_ || ending_) return;
    queue_.push_back(std::move(reply));
    write_next();
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
    ending_ = std::move(status);
    write_next();
  }
  void written(bool ok) {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) queue_.clear();
    write_next();
  }
  /// Marks the call as ended, after which no operation may start on it.
  void over() {
    const std::lock_guard lock(mutex_);
    reactor_ = nullptr;
  }

 private:
  void write_next() {
    if (!reactor_ || writing_ || finished_) return;
    if (!queue_.empty()) {
      writing_ = true;
      reply_ = std::move(queue_.front());
      queue_.pop_front();
      reactor_->StartWrite(&reply_);
    } else if (ending_) {
      finished_ = true;
      reactor_->Finish(*ending_);
    }
  }

  std::mutex mutex_;
  Reactor* reactor_;
  std::deque<v1::AssistReply> queue_;
  v1::AssistReply reply_;
  bool writing_ = false, finished_ = false;
  std::optional<grpc::Status> ending_;
};

/// Deletes itself when gRPC is done with it. If `host` is null, this worker assists nobody.
class AssistReactor final : public AssistStream::Reactor {
 public:
  explicit AssistReactor(AssistHost* host) : stream_(std::make_shared<AssistStream>(this)) {
    Result<std::shared_ptr<AssistHost::Session>> opened =
        fail(ErrorCode::kUnavailable, "This render worker does not assist other workers.");
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
