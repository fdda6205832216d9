#include "renderd/schedule/lanes.h"

#include <algorithm>

#include "common/background.h"

namespace diaphane::render {

Lanes::Lanes(std::size_t most, int nice) : most_(std::max<std::size_t>(most, 1)), nice_(nice) {}

Lanes::~Lanes() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  begin_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Lanes::start(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(work));
    if (free_ < waiting_.size() && threads_.size() < most_) {
      threads_.emplace_back([this] { lane(); });
    }
  }
  begin_.notify_one();
}

void Lanes::lane() {
  if (nice_ != 0) background::enter(nice_);
  std::unique_lock lock(mutex_);
  for (;;) {
    ++free_;
    begin_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
    --free_;
    if (waiting_.empty()) return;
    const auto work = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    work();
    lock.lock();
  }
}

}  // namespace diaphane::render
