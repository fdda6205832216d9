#include "common/background.h"

#include <sched.h>
#include <sys/resource.h>

#include <atomic>

namespace diaphane::background {
namespace {

std::atomic<unsigned> most_cores = 0;

void use_first(unsigned cores) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  for (std::size_t i = 0, kept = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &allowed) && kept++ >= cores) CPU_CLR(i, &allowed);
  }
  (void)sched_setaffinity(0, sizeof allowed, &allowed);
}

}  // namespace

void limit_cores(unsigned cores) { most_cores = cores; }

void enter(int nice) {
  // On Linux, each thread has its own nice value and core affinity.
  if (nice != 0) (void)setpriority(PRIO_PROCESS, 0, nice);
  if (most_cores > 0) use_first(most_cores);
}

}  // namespace diaphane::background
