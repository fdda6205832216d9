#include "renderd/encode/encode_pool.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

namespace diaphane::render {

EncodePool::EncodePool(unsigned threads) {
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
  // On Linux the priority is per thread. The pool also works without it.
  if (nice != 0) (void)setpriority(PRIO_PROCESS, 0, nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    queue.ready.wait(lock, [&] { return !queue.jobs.empty() || ended(); });
    if (queue.jobs.empty()) return;
    {
      const Job job = take_first(queue);
      ++running_;
      lock.unlock();
      job.work();
    }
    lock.lock();
    --running_;
    if (!ended()) continue;
    for (Queue& each : queues_) each.ready.notify_all();
  }
}

}  // namespace diaphane::render
