#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::api {

/// A bounded pool: `threads` work, at most `room` wait. The HTTP library's few threads only hand
/// over to it, because one of them blocked is one that serves nobody.
class Executor {
 public:
  Executor(int threads, std::size_t room);
  /// Finishes what is running and what waits.
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// False when there is no room; then `work` was not taken. `work` must not throw.
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
