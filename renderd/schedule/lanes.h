#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that drive several renderers of one device at once: each renderer has a stream of its
/// own, and one thread waits for one stream. They are started with the first work that needs them.
class Lanes {
 public:
  /// At most `most` at once, at least one; more than that wait for each other in their order.
  explicit Lanes(std::size_t most);
  /// Ends what was given.
  ~Lanes();
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;

  /// Returns at once. `work` must not throw.
  void start(std::function<void()> work);

 private:
  void lane();

  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable begin_;
  std::deque<std::function<void()>> waiting_;
  std::size_t free_ = 0;  // threads that wait for work
  bool closing_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
