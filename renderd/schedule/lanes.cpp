#include "renderd/schedule/lanes.h"

#include <algorithm>

namespace diaphane::render {

Lanes::~Lanes() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  begin_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Lanes::run(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (count == 1 || most_ <= 1) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  while (threads_.size() + 1 < std::min(most_, count)) threads_.emplace_back([this] { lane(); });
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    next_ = done_ = 0;
    count_ = count;
  }
  begin_.notify_all();
  take();
  std::unique_lock lock(mutex_);
  end_.wait(lock, [this] { return done_ == count_; });
  count_ = 0;
}

void Lanes::take() {
  std::unique_lock lock(mutex_);
  while (next_ < count_) {
    const std::size_t piece = next_++;
    const auto& work = *work_;
    lock.unlock();
    work(piece);
    lock.lock();
    if (++done_ == count_) end_.notify_all();
  }
}

void Lanes::lane() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      begin_.wait(lock, [this] { return closing_ || next_ < count_; });
      if (closing_) return;
    }
    take();
  }
}

}  // namespace diaphane::render
