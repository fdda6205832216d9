#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// A pool of threads that drive several renderers of one device at once. Each renderer has its own
/// stream, and one thread waits for one stream. A thread is started when work arrives and none is
/// free.
class Lanes {
 public:
  /// Runs at most `most` pieces of work at once, or one if `most` is 0. Further work waits in order
  /// of arrival. Unless `nice` is 0, the threads have that nice value and the cores of background
  /// work.
  explicit Lanes(std::size_t most, int nice = 0);
  /// Finishes all work that was started.
  ~Lanes();
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;

  /// Queues `work`, which must not throw, and returns immediately.
  void start(std::function<void()> work);

 private:
  void lane();

  const std::size_t most_;
  const int nice_;
  std::mutex mutex_;
  std::condition_variable begin_;
  std::deque<std::function<void()>> waiting_;
  std::size_t free_ = 0;  // number of threads that wait for work
  bool closing_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
