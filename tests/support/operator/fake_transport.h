#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

#include "operator/kube/transport.h"

namespace diaphane::kube {

/// Returns prepared responses in order. A call without one blocks until stop(). For faults that a
/// real server cannot produce on demand.
class FakeTransport final : public Transport {
 public:
  struct Answer {
    int status = 200;  ///< 0: connection broken
    std::string body;
    bool stays_open = false;  ///< a stream that stays open without sending a byte
  };

  void put(Answer answer) {
    const std::lock_guard lock(mutex_);
    answers_.push_back(std::move(answer));
    changed_.notify_all();
  }
  std::vector<Request> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

  Result<Response> call(const Request& request, std::chrono::milliseconds) override {
    return next(request, {}, nullptr);
  }
  Result<Response> stream(const Request& request, std::chrono::milliseconds silence,
                          const std::function<bool(std::string_view)>& bytes) override {
    return next(request, silence, &bytes);
  }
  void stop() override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

 private:
  Result<Response> next(const Request& request, std::chrono::milliseconds silence,
                        const std::function<bool(std::string_view)>* bytes) {
    std::unique_lock lock(mutex_);
    asked_.push_back(request);
    changed_.wait(lock, [this] { return stopped_ || !answers_.empty(); });
    if (stopped_) return fail(ErrorCode::kUnavailable, "stopped");
    const Answer answer = std::move(answers_.front());
    answers_.pop_front();
    lock.unlock();
    if (bytes && answer.status == 200 && !((*bytes)({}) && (*bytes)(answer.body))) {
      return Response{200, {}};
    }
    lock.lock();
    if (answer.stays_open && !changed_.wait_for(lock, silence, [this] { return stopped_; })) {
      return fail(ErrorCode::kUnavailable, "silent");
    }
    if (answer.status == 0) return fail(ErrorCode::kUnavailable, "broken");
    return Response{answer.status, bytes && answer.status == 200 ? "" : answer.body};
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Answer> answers_;
  std::vector<Request> asked_;
  bool stopped_ = false;
};

}  // namespace diaphane::kube
