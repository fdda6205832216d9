#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that encode pictures, apart from the rendering thread. Each urgency has its own threads,
/// so that an urgent job never waits for a long one, nor a small picture for a large one. Jobs of
/// one urgency start in the order of their deadlines; the queues stay short because each session
/// has at most one job in them (EncodeLane).
class EncodePool {
 public:
  enum class Urgency {
    kNow,       ///< a user waits for it: moving pictures and the first picture of an epoch
    kNowLarge,  ///< kNow for a picture of more than `kSmallPixels`, which takes long
    kLater,     ///< refinement at rest, and all work for visitors; runs at a lower CPU priority
  };
  /// About what one thread encodes in 5 ms.
  static constexpr std::size_t kSmallPixels = std::size_t{640} * 400;
  /// Nice value of the threads for kLater, which gives them a third of the weight of other threads
  /// when the CPU is contended.
  static constexpr int kLaterNice = 5;

  /// Starts `threads` threads per urgency. After a job, its thread rests `rest` times as long as
  /// the job took, so that jobs take at most 1 / (1 + rest) of a core.
  explicit EncodePool(unsigned threads, double rest = 0);
  /// Runs the queued jobs before it returns.
  ~EncodePool();
  EncodePool(const EncodePool&) = delete;
  EncodePool& operator=(const EncodePool&) = delete;

  /// Queues a job for a picture of `pixels`. The deadline of a job is kPatience times its expected
  /// duration after now. So many sessions with larger pictures hardly delay one with a smaller one,
  /// and no job waits without end.
  void post(Urgency urgency, std::function<void()> job, std::size_t pixels = 0);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kPatience = 8;

  struct Job {
    std::function<void()> work;
    Clock::time_point deadline;
  };
  struct Queue {
    std::condition_variable ready{};
    std::deque<Job> jobs{};
    std::vector<std::thread> threads{};
  };

  Queue& queue_of(Urgency urgency) { return queues_[static_cast<std::size_t>(urgency)]; }
  void work(Queue& queue, int nice);
  static Job take_first(Queue& queue);  // requires the lock
  bool ended() const;  // requires the lock: stopping, and no remaining job can post another

  const double rest_;
  std::mutex mutex_;
  std::array<Queue, 3> queues_;  // by urgency
  std::condition_variable rested_;
  unsigned running_ = 0;
  bool stopping_ = false;
};

}  // namespace diaphane::render
