#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that code pictures, apart from the rendering thread. Jobs of a kind run in the order
/// given; what keeps the queue short is that each session has at most one job in it (EncodeLane).
class EncodePool {
 public:
  enum class Urgency {
    kNow,    ///< somebody's hand waits for it: pictures that move, the first of an epoch
    kLater,  ///< what gets better at rest: a lossless tile takes as long as ten moving pictures
  };
  /// Of those that are urgent, at most so many in a row while others wait.
  static constexpr int kUrgentInARow = 7;

  explicit EncodePool(unsigned threads);
  /// Runs what is queued, then ends.
  ~EncodePool();
  EncodePool(const EncodePool&) = delete;
  EncodePool& operator=(const EncodePool&) = delete;

  void post(Urgency urgency, std::function<void()> job);

 private:
  void work();
  std::function<void()> take();

  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<std::function<void()>> now_, later_;
  int in_a_row_ = 0;  // urgent ones, while others waited
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace diaphane::render
