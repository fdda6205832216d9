#include "renderd/engine/thread_pool.h"

#include <algorithm>

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
                     const std::function<bool()>& before_each) {
  Loop loop{.work = work, .count = count};
  {
    std::lock_guard lock(mutex_);
    loops_.push_back(&loop);
  }
  begin_.notify_all();
  take_pieces(loop, before_each);
  std::unique_lock lock(mutex_);
  // From here on nobody new comes to it.
  loops_.remove(&loop);
  loop.end.wait(lock, [&] { return loop.busy == 0; });
  return !loop.stopped;
}

void ThreadPool::take_pieces(Loop& loop, const std::function<bool()>& before_each) {
  for (;;) {
    if (before_each && before_each()) loop.stopped = true;
    if (loop.stopped) return;
    const std::uint32_t piece = loop.next.fetch_add(1);
    if (piece >= loop.count) return;
    loop.work(piece);
  }
}

ThreadPool::Loop* ThreadPool::open_loop() {
  Loop* fewest = nullptr;
  for (Loop* loop : loops_) {
    if (loop->open() && (!fewest || loop->busy < fewest->busy)) fewest = loop;
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
    take_pieces(*loop, nullptr);
    lock.lock();
    if (--loop->busy == 0) loop->end.notify_one();
  }
}

}  // namespace diaphane::render
