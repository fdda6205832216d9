#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <mutex>
#include <optional>

// The writing side of a streaming call. To be included only by grpc_server.cpp and
// assist_reactor.h.

namespace diaphane::render {

/// Writes one message at a time, then the status. It outlives the call, because senders may hold it
/// slightly longer. Derived classes must hold `mutex_` when they use protected members.
template <typename Request, typename Reply>
class ReplyQueue {
 public:
  using Reactor = grpc::ServerBidiReactor<Request, Reply>;

  explicit ReplyQueue(Reactor* reactor) : reactor_(reactor) {}

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

 protected:
  bool open() const { return reactor_ != nullptr && !ending_; }
  void push(Reply reply) {
    queue_.push_back(std::move(reply));
    write_next();
  }
  void end(grpc::Status status) {
    ending_ = std::move(status);
    write_next();
  }

  std::mutex mutex_;
  Reactor* reactor_;
  std::deque<Reply> queue_;
  std::optional<grpc::Status> ending_;
  bool finished_ = false;

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

  Reply reply_;
  bool writing_ = false;
};

}  // namespace diaphane::render
