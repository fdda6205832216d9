#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::api {

/// A bounded thread pool with `threads` workers and a queue of `room` tasks. The few threads of the
/// HTTP library must never block, so they only hand tasks over to this pool.
class Executor {
 public:
  Executor(int threads, std::size_t room);
  /// Finishes the running and the queued tasks.
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Returns false and does not run `work` if the queue is full. `work` must not throw.
  bool submit(std::function<void()> work);
  std::size_t waiting() const;

 private:
  void run();

  const std::size_t room_;
  mutable std::mutex mutex_;
  std::condition_variable more_;
  std::deque<std::function<void()>> queue_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::api
