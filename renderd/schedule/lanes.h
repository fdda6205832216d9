#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that drive several renderers of one device at once: each renderer has a stream of its
/// own, and one thread waits for one stream. They are started with the first round that needs them.
class Lanes {
 public:
  /// At most `most` at once, the caller's thread among them.
  explicit Lanes(std::size_t most) : most_(most) {}
  ~Lanes();
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;

  /// Calls `work(i)` once for each i below `count` and returns when all are done. From one thread
  /// at a time; `work` must not throw.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void take();  // under no lock
  void lane();

  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable begin_, end_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::size_t next_ = 0, count_ = 0, done_ = 0;
  bool closing_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
