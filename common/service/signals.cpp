#include "common/service/signals.h"

#include <csignal>
#include <ctime>

namespace diaphane::service {
namespace {
sigset_t stop_set() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}
}  // namespace

StopSignal::StopSignal() {
  const sigset_t set = stop_set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  // Exceeding a file size limit should only fail the write, as on a full disk, and not end the
  // process.
  std::signal(SIGXFSZ, SIG_IGN);
}

int StopSignal::wait() {
  const sigset_t set = stop_set();
  int number = 0;
  while (sigwait(&set, &number) != 0) {
  }
  return number;
}

bool StopSignal::wait_for(std::chrono::milliseconds timeout) {
  const sigset_t set = stop_set();
  const timespec span{static_cast<std::time_t>(timeout.count() / 1000),
                      static_cast<long>(timeout.count() % 1000) * 1000000L};
  return sigtimedwait(&set, nullptr, &span) > 0;
}

}  // namespace diaphane::service
