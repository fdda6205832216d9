#include "common/sandbox/sandbox.h"

#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <initializer_list>
#include <memory>

namespace diaphane {
namespace {

constexpr std::uint64_t kStackBytes = std::uint64_t{8} << 20;

bool limit(__rlimit_resource resource, std::uint64_t value) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0) return false;
  // Keeps a stricter limit that the environment sets.
  const rlim_t most = std::min<rlim_t>(now.rlim_max, value);
  const rlimit limits{most, most};
  return setrlimit(resource, &limits) == 0;
}

// System calls needed to read an upload and to build a volume or labels from it (from strace of
// every pixel packing).
constexpr std::array kAllowed{
    SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(futex),
    // These concern only time, random numbers and the process itself.
    SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom), SCMP_SYS(getpid),
    SCMP_SYS(gettid), SCMP_SYS(sched_yield), SCMP_SYS(sched_getaffinity), SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(close), SCMP_SYS(exit),
    SCMP_SYS(exit_group)};

// Libraries call these and continue on failure: libarchive and iostreams query the type of a
// descriptor, glibc looks for character sets (gconv), and VTK counts processors. Any other call
// ends the process.
constexpr std::array kRefused{SCMP_SYS(openat),          SCMP_SYS(open),    SCMP_SYS(newfstatat),
                              SCMP_SYS(fstat),           SCMP_SYS(stat),    SCMP_SYS(lstat),
                              SCMP_SYS(statx),           SCMP_SYS(access),  SCMP_SYS(readlink),
                              SCMP_SYS(readlinkat),      SCMP_SYS(ioctl),   SCMP_SYS(fcntl),
                              SCMP_SYS(getcwd),          SCMP_SYS(uname),   SCMP_SYS(sysinfo),
                              SCMP_SYS(clone),           SCMP_SYS(clone3),  SCMP_SYS(prlimit64),
                              SCMP_SYS(getrlimit),       SCMP_SYS(getuid),  SCMP_SYS(geteuid),
                              SCMP_SYS(getgid),          SCMP_SYS(getegid), SCMP_SYS(getdents64),
                              SCMP_SYS(set_robust_list), SCMP_SYS(rseq)};

bool filter_calls(const SandboxLimits& limits) {
  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_KILL_PROCESS),
                                                                seccomp_release);
  if (!filter) return false;
  bool ok = seccomp_attr_set(filter.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS) == 0;
  const auto add = [&](std::uint32_t action, int call, std::initializer_list<scmp_arg_cmp> when) {
    ok = ok && seccomp_rule_add_array(filter.get(), action, call,
                                      static_cast<unsigned>(when.size()), when.begin()) == 0;
  };
  const auto allow = [&](int call, std::initializer_list<scmp_arg_cmp> when = {}) {
    add(SCMP_ACT_ALLOW, call, when);
  };
  for (const int call : kAllowed) allow(call);
  for (const int call : kRefused) add(SCMP_ACT_ERRNO(EACCES), call, {});
  // Only the input may be read, and only the descriptors opened for output may be written (0 to 2
  // are /dev/null).
  const auto input = static_cast<scmp_datum_t>(limits.input);
  const auto last = static_cast<scmp_datum_t>(limits.last_output);
  for (const int call : {SCMP_SYS(read), SCMP_SYS(lseek)}) {
    allow(call, {SCMP_A0(SCMP_CMP_EQ, input)});
  }
  for (const int call : {SCMP_SYS(write), SCMP_SYS(writev)}) {
    allow(call, {SCMP_A0(SCMP_CMP_LE, last)});
  }
  // Allows memory, but not executable memory.
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)}) {
    allow(call, {SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
  }
  // abort(3) signals its own thread. Signals to other programs of the same user are not allowed.
  allow(SCMP_SYS(tgkill),
        {SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())), SCMP_A2(SCMP_CMP_EQ, SIGABRT)});
  return ok && seccomp_load(filter.get()) == 0;
}

}  // namespace

Result<void> enter_sandbox(const SandboxLimits& limits) {
  // A core file would contain the images.
  const bool limited =
      limit(RLIMIT_CORE, 0) && limit(RLIMIT_AS, limits.memory_bytes) &&
      limit(RLIMIT_STACK, kStackBytes) && limit(RLIMIT_FSIZE, limits.output_bytes) &&
      limit(RLIMIT_CPU, limits.cpu_seconds) &&
      limit(RLIMIT_NOFILE, static_cast<std::uint64_t>(limits.last_output) + 1) &&
      limit(RLIMIT_NPROC, 0) && limit(RLIMIT_MEMLOCK, 0) && limit(RLIMIT_MSGQUEUE, 0);
  if (!limited) return fail(ErrorCode::kInternal, "cannot set the limits of the sandbox");
  if (prctl(PR_SET_DUMPABLE, 0) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
    return fail(ErrorCode::kInternal, "cannot drop privileges");
  }
  if (!filter_calls(limits))
    return fail(ErrorCode::kInternal, "cannot install the system call filter");
  return {};
}

}  // namespace diaphane
