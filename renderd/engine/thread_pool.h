#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that stay, for loops of independent pieces of work. The caller works too, so a pool of n
/// threads starts n - 1. One loop at a time; callers from several threads take turns.
class ThreadPool {
 public:
  /// 0: as many as the machine has cores.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const { return static_cast<unsigned>(workers_.size()) + 1; }

  /// Calls `work(i)` once for each i in [0, count), in any order, and returns when all are done.
  /// `before_each`, if any, is asked on the calling thread alone before each of its pieces; true
  /// leaves out what is not yet begun, and the result is false. `work` must not throw.
  bool run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
           const std::function<bool()>& before_each = nullptr);

 private:
  void worker();
  void take_pieces(const std::function<bool()>& before_each);

  std::mutex turn_;  ///< held for a whole loop
  std::mutex mutex_;
  std::condition_variable begin_, end_;
  std::uint64_t loop_ = 0;  ///< number of the loop under way; workers wait for a change
  unsigned busy_ = 0;
  bool closing_ = false;
  const std::function<void(std::uint32_t)>* work_ = nullptr;
  std::uint32_t count_ = 0;
  std::atomic<std::uint32_t> next_{0};
  std::atomic<bool> stopped_{false};
  std::vector<std::thread> workers_;
};

}  // namespace diaphane::render
