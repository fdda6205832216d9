#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that code pictures, apart from the rendering thread. Jobs run in the order given; what
/// keeps the queue short is that each session has at most one job in it (EncodeLane).
class EncodePool {
 public:
  explicit EncodePool(unsigned threads);
  /// Runs what is queued, then ends.
  ~EncodePool();
  EncodePool(const EncodePool&) = delete;
  EncodePool& operator=(const EncodePool&) = delete;

  void post(std::function<void()> job);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<std::function<void()>> jobs_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
