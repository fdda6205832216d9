#include "renderd/serve/watchdog.h"

#include <algorithm>

namespace diaphane::render {

Watchdog::Watchdog(std::vector<Watched> watched, Options options)
    : watched_(std::move(watched)), options_(std::move(options)), states_(watched_.size()) {
  thread_ = std::thread([this] { run(); });
}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Watchdog::run() {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, options_.poll_interval, [this] { return stopping_; })) {
    lock.unlock();
    poll();
    lock.lock();
  }
}

void Watchdog::poll() {
  std::uint64_t most = 0;
  const std::string* longest = nullptr;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const std::uint64_t pulse = watched_[i].pulse();
    State& state = states_[i];
    state.silent_polls = pulse == 0 || pulse != state.pulse ? 0 : state.silent_polls + 1;
    state.pulse = pulse;
    if (state.silent_polls > most) {
      most = state.silent_polls;
      longest = &watched_[i].name;
    }
  }
  const auto silence = most * options_.poll_interval;
  suspects_ = 2 * silence >= options_.limit;
  if (silence < options_.limit || !longest || reported_) return;
  reported_ = true;
  options_.hung(*longest);
}

std::vector<Watchdog::Watched> watched(const ProgressMonitor& monitor) {
  std::vector<Watchdog::Watched> all;
  for (std::size_t i = 0; i < ProgressMonitor::kPlaces; ++i) {
    all.push_back({"device", [&monitor, i] { return monitor.at(i); }});
  }
  return all;
}

}  // namespace diaphane::render
