#include "operator/kube/work_queue.h"

#include <algorithm>

namespace diaphane::kube {

void WorkQueue::put(const std::string& key, Time due) {
  if (const auto failure = failures_.find(key); failure != failures_.end()) {
    due = std::max(due, failure->second.until);
  }
  (taken_.contains(key) ? again_ : due_).insert_or_assign(key, due);
}

std::optional<std::string> WorkQueue::take(Time now) {
  const auto first = std::min_element(
      due_.begin(), due_.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (first == due_.end() || first->second > now) return std::nullopt;
  std::string key = first->first;
  due_.erase(first);
  taken_.insert(key);
  return key;
}

void WorkQueue::done(const std::string& key) {
  taken_.erase(key);
  if (const auto again = again_.find(key); again != again_.end()) {
    const Time due = again->second;
    again_.erase(again);
    put(key, due);
  }
}

void WorkQueue::failed(const std::string& key, Time now) {
  Failure& failure = failures_[key];
  auto pause = kLongest;
  // With more doublings, the pause exceeds the maximum.
  if (failure.count < 18) pause = std::min(kLongest, kFirst * (1 << failure.count));
  ++failure.count;
  failure.until = now + pause;
  put(key, failure.until);
}

std::optional<WorkQueue::Time> WorkQueue::next() const {
  std::optional<Time> next;
  for (const auto& [key, due] : due_) {
    if (!next || due < *next) next = due;
  }
  return next;
}

int WorkQueue::failures(const std::string& key) const {
  const auto found = failures_.find(key);
  return found == failures_.end() ? 0 : found->second.count;
}

}  // namespace diaphane::kube
