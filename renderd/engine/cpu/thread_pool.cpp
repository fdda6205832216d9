#include "renderd/engine/cpu/thread_pool.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "common/background.h"

namespace diaphane::render {
namespace {

// Returns the nice value of the calling thread. On Linux, each thread has its own.
int nice_value() { return getpriority(PRIO_PROCESS, 0); }

}  // namespace

ThreadPool::ThreadPool(unsigned threads) {
  if (threads == 0) threads = std::max(std::thread::hardware_concurrency(), 1u);
  for (unsigned i = 1; i < threads; ++i) {
    for (const Kind kind : {Kind::kBackground, Kind::kUrgent}) {
      workers_.emplace_back([this, kind] { worker(kind); });
    }
  }
}

ThreadPool::~ThreadPool() {
  {
    std::lock_guard lock(mutex_);
    closing_ = true;
  }
  begin_.notify_all();
  for (std::thread& t : workers_) t.join();
}

std::uint32_t ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                              const std::function<bool()>& before_each, unsigned precedence,
                              std::uint32_t first) {
  const std::atomic<unsigned> fixed(std::min(precedence, kPrecedences - 1));
  return run(count, work, before_each, fixed, first);
}

std::uint32_t ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                              const std::function<bool()>& before_each,
                              const std::atomic<unsigned>& precedence, std::uint32_t first) {
  Loop loop{
      .work = work, .count = count, .precedence = precedence, .nice = nice_value(), .next{first}};
  {
    std::lock_guard lock(mutex_);
    loop.counted = precedence;
    loops_.push_back(&loop);
    count_loop(loop.counted, 1);
  }
  begin_.notify_all();
  take_own_pieces(loop, before_each);
  std::unique_lock lock(mutex_);
  // After this, no other thread joins the loop.
  loops_.remove(&loop);
  loop.end.wait(lock, [&] { return loop.busy == 0; });
  count_loop(loop.counted, -1);
  return std::min<std::uint32_t>(loop.next, count);
}

void ThreadPool::raise(std::atomic<unsigned>& precedence, unsigned value) {
  const std::lock_guard lock(mutex_);
  if (precedence >= value) return;
  precedence = value;
  bool raised = false;
  for (Loop* loop : loops_) {
    if (&loop->precedence != &precedence) continue;
    --running_[loop->counted];
    ++running_[value];
    loop->counted = value;
    raised = true;
  }
  if (!raised) return;
  find_highest();
  begin_.notify_all();
}

void ThreadPool::count_loop(unsigned precedence, int change) {
  running_[precedence] += change;
  const unsigned before = highest_;
  find_highest();
  if (highest_ < before) begin_.notify_all();
}

void ThreadPool::find_highest() {
  unsigned highest = kPrecedences - 1;
  while (highest > 0 && running_[highest] == 0) --highest;
  highest_ = highest;
}

void ThreadPool::take_own_pieces(Loop& loop, const std::function<bool()>& before_each) {
  for (;;) {
    if (pauses(loop)) wait_while_paused(loop, before_each);
    if (before_each && before_each()) loop.stopped = true;
    if (loop.stopped) return;
    const std::uint32_t piece = loop.next.fetch_add(1);
    if (piece >= loop.count) return;
    loop.work(piece);
  }
}

void ThreadPool::wait_while_paused(Loop& loop, const std::function<bool()>& before_each) {
  constexpr std::chrono::milliseconds kBetweenCalls(4);
  std::unique_lock lock(mutex_);
  while (pauses(loop) && !loop.stopped) {
    if (begin_.wait_for(lock, kBetweenCalls, [&] { return !pauses(loop); })) return;
    lock.unlock();
    if (before_each && before_each()) loop.stopped = true;
    lock.lock();
  }
}

void ThreadPool::take_pieces(Loop& loop) {
  while (!loop.stopped && !pauses(loop)) {
    const std::uint32_t piece = loop.next.fetch_add(1);
    if (piece >= loop.count) return;
    loop.work(piece);
  }
}

ThreadPool::Loop* ThreadPool::open_loop(Kind kind) {
  Loop* fewest = nullptr;
  for (Loop* loop : loops_) {
    if (kind_of(*loop) != kind || !loop->open() || pauses(*loop)) continue;
    if (!fewest || loop->busy < fewest->busy) fewest = loop;
  }
  return fewest;
}

void ThreadPool::worker(Kind kind) {
  int nice = nice_value();
  std::unique_lock lock(mutex_);
  for (;;) {
    Loop* loop = nullptr;
    begin_.wait(lock, [&] { return closing_ || (loop = open_loop(kind)) != nullptr; });
    if (closing_) return;
    ++loop->busy;
    lock.unlock();
    if (kind == Kind::kBackground && loop->nice > nice) {
      nice = loop->nice;
      background::enter(nice);
    }
    take_pieces(*loop);
    lock.lock();
    if (--loop->busy == 0) loop->end.notify_one();
  }
}

}  // namespace diaphane::render
