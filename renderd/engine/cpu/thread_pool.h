#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// A pool of threads for loops of independent pieces of work. The caller works too, so a pool of n
/// threads has n - 1 for loops of precedence 0 and n - 1 for the others. Loops of several callers
/// run concurrently: each caller works on its own loop, and the threads of the pool join the loop
/// with the fewest workers. While a loop runs, all loops of lower precedence pause between two
/// pieces. The threads for precedence 0 adopt the nice value of a caller if it is higher, so that
/// the pieces that they still have to finish hardly delay a loop of higher precedence.
class ThreadPool {
 public:
  /// Precedences range from 0, which pauses no other loop, to kPrecedences - 1.
  static constexpr unsigned kPrecedences = 8;

  /// `threads` is the number of threads; 0 means one per core.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const { return static_cast<unsigned>(workers_.size()) / 2 + 1; }

  /// Calls `work(i)` once for each i in [first, count), in any order, and returns when all calls
  /// have returned. Calls `before_each`, if it is set, only on the calling thread: before each of
  /// that thread's pieces, and repeatedly during a pause. If `before_each` returns true, the pieces
  /// that have not begun are skipped. Returns the first piece that was not called, so that another
  /// loop can begin there; this is `count` unless the loop was stopped. `work` must not throw and
  /// must not call run().
  std::uint32_t run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                    const std::function<bool()>& before_each = nullptr, unsigned precedence = 0,
                    std::uint32_t first = 0);
  /// Works like the function above, with a precedence that raise() can change while the loop runs.
  std::uint32_t run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                    const std::function<bool()>& before_each,
                    const std::atomic<unsigned>& precedence, std::uint32_t first = 0);
  /// Raises `precedence` to at least `value`, also for loops that run with it. Thread-safe.
  void raise(std::atomic<unsigned>& precedence, unsigned value);

 private:
  struct Loop {
    const std::function<void(std::uint32_t)>& work;
    std::uint32_t count;
    const std::atomic<unsigned>& precedence;
    int nice;              // nice value of the caller
    unsigned counted = 0;  // precedence under which `running_` counts this loop
    std::atomic<std::uint32_t> next{0};
    std::atomic<bool> stopped{false};
    unsigned busy = 0;  // number of workers in this loop
    std::condition_variable end{};

    bool open() const { return !stopped && next < count; }
  };

  enum class Kind { kBackground, kUrgent };
  static Kind kind_of(const Loop& loop) {
    return loop.precedence > 0 ? Kind::kUrgent : Kind::kBackground;
  }

  void worker(Kind kind);
  // Returns the loop with the fewest workers among those that may run. Requires the lock.
  Loop* open_loop(Kind kind);
  bool pauses(const Loop& loop) const { return loop.precedence < highest_; }
  // These two functions require the lock.
  void count_loop(unsigned precedence, int change);
  void find_highest();
  void take_pieces(Loop& loop);
  void take_own_pieces(Loop& loop, const std::function<bool()>& before_each);
  void wait_while_paused(Loop& loop, const std::function<bool()>& before_each);

  std::mutex mutex_;
  std::condition_variable begin_;
  std::list<Loop*> loops_;                   ///< on their callers' stacks
  std::array<int, kPrecedences> running_{};  ///< loops of each precedence
  std::atomic<unsigned> highest_{0};         ///< highest precedence of a running loop
  bool closing_ = false;
  std::vector<std::thread> workers_;
};

/// One renderer's view of a pool. The precedence of the renderer's loops is set between its
/// pictures and can be raised while a loop runs.
class RendererThreads {
 public:
  explicit RendererThreads(ThreadPool& pool) : pool_(pool) {}

  void set_precedence(unsigned precedence) {
    precedence_ = std::min(precedence, ThreadPool::kPrecedences - 1);
  }
  /// Raises the precedence, even while a loop runs. Thread-safe.
  void raise_precedence(unsigned precedence) {
    pool_.raise(precedence_, std::min(precedence, ThreadPool::kPrecedences - 1));
  }
  std::uint32_t run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                    const std::function<bool()>& before_each = nullptr, std::uint32_t first = 0) {
    return pool_.run(count, work, before_each, precedence_, first);
  }

 private:
  ThreadPool& pool_;
  std::atomic<unsigned> precedence_{0};
};

}  // namespace diaphane::render
