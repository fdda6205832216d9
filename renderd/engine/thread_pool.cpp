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
  std::lock_guard turn(turn_);
  {
    std::lock_guard lock(mutex_);
    work_ = &work;
    count_ = count;
    next_ = 0;
    stopped_ = false;
    busy_ = static_cast<unsigned>(workers_.size());
    ++loop_;
  }
  begin_.notify_all();
  take_pieces(before_each);
  std::unique_lock lock(mutex_);
  end_.wait(lock, [this] { return busy_ == 0; });
  work_ = nullptr;
  return !stopped_;
}

void ThreadPool::take_pieces(const std::function<bool()>& before_each) {
  for (;;) {
    if (before_each && before_each()) stopped_ = true;
    if (stopped_) return;
    const std::uint32_t piece = next_.fetch_add(1);
    if (piece >= count_) return;
    (*work_)(piece);
  }
}

void ThreadPool::worker() {
  std::uint64_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      begin_.wait(lock, [&] { return closing_ || loop_ != seen; });
      if (closing_) return;
      seen = loop_;
    }
    take_pieces(nullptr);
    std::lock_guard lock(mutex_);
    if (--busy_ == 0) end_.notify_one();
  }
}

}  // namespace diaphane::render
