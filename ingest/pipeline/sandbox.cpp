#include "ingest/pipeline/sandbox.h"

#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>

namespace diaphane::ingest {
namespace {

bool limit(__rlimit_resource resource, std::uint64_t value) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0) return false;
  // A stricter limit from outside stays.
  const rlim_t most = std::min<rlim_t>(now.rlim_max, value);
  const rlimit wanted{most, most};
  return setrlimit(resource, &wanted) == 0;
}

constexpr std::array kAllowed{
    // what is open already
    SCMP_SYS(read), SCMP_SYS(readv), SCMP_SYS(pread64), SCMP_SYS(write), SCMP_SYS(writev),
    SCMP_SYS(pwrite64), SCMP_SYS(lseek), SCMP_SYS(fstat), SCMP_SYS(close),
    // memory
    SCMP_SYS(brk), SCMP_SYS(mmap), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(mprotect),
    SCMP_SYS(madvise), SCMP_SYS(futex),
    // time, randomness, itself
    SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom), SCMP_SYS(getpid),
    SCMP_SYS(gettid), SCMP_SYS(sched_yield), SCMP_SYS(sched_getaffinity), SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(exit), SCMP_SYS(exit_group)};

// Nothing that reads pictures has a reason for these: whoever tries is not to go on.
constexpr std::array kDeadly{SCMP_SYS(socket),
                             SCMP_SYS(socketpair),
                             SCMP_SYS(connect),
                             SCMP_SYS(bind),
                             SCMP_SYS(execve),
                             SCMP_SYS(execveat),
                             SCMP_SYS(fork),
                             SCMP_SYS(vfork),
                             SCMP_SYS(ptrace),
                             SCMP_SYS(kill),
                             SCMP_SYS(process_vm_readv),
                             SCMP_SYS(process_vm_writev),
                             SCMP_SYS(io_uring_setup)};

bool filter_calls() {
  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(
      seccomp_init(SCMP_ACT_ERRNO(EACCES)), seccomp_release);
  if (!filter) return false;
  for (const int call : kAllowed) {
    if (seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0) != 0) return false;
  }
  for (const int call : kDeadly) {
    if (seccomp_rule_add(filter.get(), SCMP_ACT_KILL_PROCESS, call, 0) != 0) return false;
  }
  // fstat(3) of newer C libraries: a flag and an empty name, so no name is looked up. The name
  // itself is a pointer that no filter can read, hence only with AT_EMPTY_PATH; a name given all
  // the same is looked up for its size and times at most.
  constexpr scmp_datum_t kAtEmptyPath = 0x1000;
  if (seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(newfstatat), 1,
                       SCMP_A3(SCMP_CMP_EQ, kAtEmptyPath)) != 0) {
    return false;
  }
  // abort(3) signals its own thread; nobody else can be signalled, since the process is its own.
  if (seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1,
                       SCMP_A2(SCMP_CMP_EQ, 6)) != 0) {
    return false;
  }
  return seccomp_load(filter.get()) == 0;
}

}  // namespace

Result<void> enter_sandbox(const SandboxLimits& limits) {
  // No core file: it would hold the pictures.
  const bool limited = limit(RLIMIT_CORE, 0) && limit(RLIMIT_AS, limits.memory_bytes) &&
                       limit(RLIMIT_FSIZE, limits.output_bytes) &&
                       limit(RLIMIT_CPU, limits.cpu_seconds) && limit(RLIMIT_NOFILE, 16);
  if (!limited) return fail(ErrorCode::kInternal, "the limits of the sandbox cannot be set");
  if (prctl(PR_SET_DUMPABLE, 0) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
    return fail(ErrorCode::kInternal, "privileges cannot be given up");
  }
  if (!filter_calls()) return fail(ErrorCode::kInternal, "the system calls cannot be filtered");
  return {};
}

}  // namespace diaphane::ingest
