#include "renderd/encode/encode_pool.h"

#include <algorithm>

namespace diaphane::render {

EncodePool::EncodePool(unsigned threads) {
  for (unsigned i = 0; i < std::max(threads, 1U); ++i) threads_.emplace_back([this] { work(); });
}

EncodePool::~EncodePool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  ready_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void EncodePool::post(Urgency urgency, std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    (urgency == Urgency::kNow ? now_ : later_).push_back(std::move(job));
  }
  ready_.notify_one();
}

// Under the lock; one of the two has some.
std::function<void()> EncodePool::take() {
  const bool now = !now_.empty() && (later_.empty() || in_a_row_ < kUrgentInARow);
  in_a_row_ = now && !later_.empty() ? in_a_row_ + 1 : 0;
  auto& jobs = now ? now_ : later_;
  std::function<void()> job = std::move(jobs.front());
  jobs.pop_front();
  return job;
}

void EncodePool::work() {
  for (;;) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      ready_.wait(lock, [this] { return stopping_ || !now_.empty() || !later_.empty(); });
      if (now_.empty() && later_.empty()) return;
      job = take();
    }
    job();
  }
}

}  // namespace diaphane::render
