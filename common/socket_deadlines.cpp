#include "common/socket_deadlines.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>

namespace diaphane {

SocketDeadlines::SocketDeadlines() : thread_([this] { run(); }) {}

SocketDeadlines::~SocketDeadlines() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void SocketDeadlines::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto now = std::chrono::steady_clock::now();
    next_ = SteadyTime::max();
    for (Entry& entry : entries_) {
      if (entry.passed) continue;
      if (entry.deadline <= now) {
        entry.passed = true;
        shutdown(entry.socket.get(), SHUT_RDWR);
      } else {
        next_ = std::min(next_, entry.deadline);
      }
    }
    if (next_ == SteadyTime::max()) {
      changed_.wait(lock);
    } else {
      changed_.wait_until(lock, next_);
    }
  }
}

SocketDeadlines::Guard::Guard(SocketDeadlines& deadlines, int socket, SteadyTime deadline)
    : deadlines_(deadlines) {
  Entry entry{Fd(fcntl(socket, F_DUPFD_CLOEXEC, 0)), deadline};
  bool earlier = false;
  {
    const std::lock_guard lock(deadlines_.mutex_);
    earlier = deadline < deadlines_.next_;
    entry_ = deadlines_.entries_.insert(deadlines_.entries_.end(), std::move(entry));
  }
  if (earlier) deadlines_.changed_.notify_one();
}

SocketDeadlines::Guard::~Guard() {
  std::list<Entry> done;  // closes the descriptor outside the lock
  const std::lock_guard lock(deadlines_.mutex_);
  done.splice(done.begin(), deadlines_.entries_, entry_);
}

bool SocketDeadlines::Guard::passed() const {
  const std::lock_guard lock(deadlines_.mutex_);
  return entry_->passed;
}

}  // namespace diaphane
