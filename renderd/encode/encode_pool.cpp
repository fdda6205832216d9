#include "renderd/encode/encode_pool.h"

#include <algorithm>
#include <utility>

#include "common/background.h"

namespace diaphane::render {

EncodePool::EncodePool(unsigned threads, double rest) : rest_(rest) {
  for (unsigned i = 0; i < std::max(threads, 1U); ++i) {
    for (const auto urgency : {Urgency::kNow, Urgency::kNowLarge, Urgency::kLater}) {
      Queue& queue = queue_of(urgency);
      const int nice = urgency == Urgency::kLater ? kLaterNice : 0;
      queue.threads.emplace_back([this, &queue, nice] { work(queue, nice); });
    }
  }
}

EncodePool::~EncodePool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  rested_.notify_all();
  for (Queue& queue : queues_) queue.ready.notify_all();
  for (Queue& queue : queues_) {
    for (std::thread& thread : queue.threads) thread.join();
  }
}

void EncodePool::post(Urgency urgency, std::function<void()> job, std::size_t pixels) {
  constexpr std::chrono::duration<double, std::milli> kSmallTime(5);
  const auto expected = kSmallTime * (static_cast<double>(pixels) / kSmallPixels);
  const auto deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(kPatience * expected);
  Queue& queue = queue_of(urgency);
  {
    const std::lock_guard lock(mutex_);
    queue.jobs.push_back({std::move(job), deadline});
  }
  queue.ready.notify_one();
}

bool EncodePool::ended() const {
  return stopping_ && running_ == 0 &&
         std::ranges::all_of(queues_, [](const Queue& queue) { return queue.jobs.empty(); });
}

EncodePool::Job EncodePool::take_first(Queue& queue) {
  const auto first = std::ranges::min_element(queue.jobs, {}, &Job::deadline);
  Job job = std::move(*first);
  queue.jobs.erase(first);
  return job;
}

void EncodePool::work(Queue& queue, int nice) {
  if (nice != 0) background::enter(nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    queue.ready.wait(lock, [&] { return !queue.jobs.empty() || ended(); });
    if (queue.jobs.empty()) return;
    const auto begin = Clock::now();
    {
      const Job job = take_first(queue);
      ++running_;
      lock.unlock();
      job.work();
    }
    const auto rest = rest_ * (Clock::now() - begin);
    lock.lock();
    --running_;
    if (ended()) {
      for (Queue& each : queues_) each.ready.notify_all();
    } else if (rest_ > 0) {
      rested_.wait_for(lock, rest, [this] { return stopping_; });
    }
  }
}

}  // namespace diaphane::render
