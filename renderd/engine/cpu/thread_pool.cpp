#include "renderd/engine/cpu/thread_pool.h"

#include <algorithm>
#include <chrono>

namespace diaphane::render {

ThreadPool::ThreadPool(unsigned threads) {
  if (threads == 0) threads = std::max(std::thread::hardware_concurrency(), 1u);
  for (unsigned i = 1; i < threads; ++i) workers_.emplace_back([this] { worker(); });
}

ThreadPool::~ThreadPool() {
  {
    std::lock_guard lock(mutex_);
    closing_ = true;
  }
  begin_.notify_all();
  for (std::thread& t : workers_) t.join();
}

bool ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
                     const std::function<bool()>& before_each, unsigned precedence) {
  precedence = std::min(precedence, kPrecedences - 1);
  Loop loop{.work = work, .count = count, .precedence = precedence};
  {
    std::lock_guard lock(mutex_);
    loops_.push_back(&loop);
    count_loop(precedence, 1);
  }
  begin_.notify_all();
  take_own_pieces(loop, before_each);
  std::unique_lock lock(mutex_);
  // After this, no other thread joins the loop.
  loops_.remove(&loop);
  loop.end.wait(lock, [&] { return loop.busy == 0; });
  count_loop(precedence, -1);
  return !loop.stopped;
}

void ThreadPool::count_loop(unsigned precedence, int change) {
  running_[precedence] += change;
  unsigned highest = kPrecedences - 1;
  while (highest > 0 && running_[highest] == 0) --highest;
  if (highest_.exchange(highest) > highest) begin_.notify_all();
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
  constexpr std::chrono::milliseconds kBetweenCalls(20);
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

ThreadPool::Loop* ThreadPool::open_loop() {
  Loop* fewest = nullptr;
  for (Loop* loop : loops_) {
    if (!loop->open() || pauses(*loop)) continue;
    if (!fewest || loop->busy < fewest->busy) fewest = loop;
  }
  return fewest;
}

void ThreadPool::worker() {
  std::unique_lock lock(mutex_);
  for (;;) {
    Loop* loop = nullptr;
    begin_.wait(lock, [&] { return closing_ || (loop = open_loop()) != nullptr; });
    if (closing_) return;
    ++loop->busy;
    lock.unlock();
    take_pieces(*loop);
    lock.lock();
    if (--loop->busy == 0) loop->end.notify_one();
  }
}

}  // namespace diaphane::render
