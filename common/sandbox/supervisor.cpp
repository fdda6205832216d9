#include "common/sandbox/supervisor.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace diaphane {
namespace {

constexpr std::chrono::milliseconds kTick{50};

/// Replaces the forked child with `program`. Uses only calls that are safe between fork and exec in
/// a process with threads.
[[noreturn]] void become(const char* program, char* const* arguments, int input, int output,
                         int report, pid_t parent) {
  constexpr int kCannot = 127;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kCannot);  // the parent ended before the line above
  // Moves the descriptors out of the way, then to their final numbers.
  const int null = open("/dev/null", O_RDWR);
  constexpr int kAside = 16;
  const int from[] = {fcntl(null, F_DUPFD, kAside), fcntl(input, F_DUPFD, kAside),
                      fcntl(output, F_DUPFD, kAside), fcntl(report, F_DUPFD, kAside)};
  for (int fd : from) {
    if (fd < 0) _exit(kCannot);
  }
  for (int fd = 0; fd <= 2; ++fd) dup2(from[0], fd);
  dup2(from[1], kChildInput);
  dup2(from[2], kChildOutput);
  dup2(from[3], kChildReport);
  syscall(SYS_close_range, kChildReport + 1, ~0U, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGPIPE, SIG_DFL);
  char* const environment[] = {nullptr};
  execve(program, arguments, environment);
  _exit(kCannot);
}

/// Appends what the pipe contains to `report`, without waiting.
void drain(int fd, std::string& report) {
  std::array<char, 4096> part{};
  for (;;) {
    const ssize_t got = read(fd, part.data(), part.size());
    if (got <= 0) return;
    report.append(part.data(), static_cast<std::size_t>(got));
    if (report.size() > kLongestReport) report.resize(kLongestReport + 1);
  }
}

/// Returns the CPU time plus a tolerance of 100 ms, because the kernel measures a limit and a usage
/// differently.
std::chrono::milliseconds cpu_time(const rusage& usage) {
  const auto of = [](const timeval& time) {
    return std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_usec);
  };
  return std::chrono::ceil<std::chrono::milliseconds>(of(usage.ru_utime) + of(usage.ru_stime)) +
         std::chrono::milliseconds(100);
}

}  // namespace

Result<ChildEnd> run_child(const ChildCommand& command, const std::function<bool()>& proceed) {
  std::vector<char*> arguments{const_cast<char*>(command.program.c_str())};
  for (const std::string& word : command.arguments) {
    arguments.push_back(const_cast<char*>(word.c_str()));
  }
  arguments.push_back(nullptr);
  std::array<int, 2> pipe{};
  if (pipe2(pipe.data(), O_CLOEXEC) != 0) return fail(ErrorCode::kInternal, "cannot create a pipe");
  fcntl(pipe[0], F_SETFL, O_NONBLOCK);
  const pid_t self = getpid();
  const pid_t child = fork();
  if (child == 0) {
    become(command.program.c_str(), arguments.data(), command.input, command.output, pipe[1], self);
  }
  close(pipe[1]);
  if (child < 0) {
    close(pipe[0]);
    return fail(ErrorCode::kInternal, "cannot create a child process");
  }

  ChildEnd end;
  const auto deadline = std::chrono::steady_clock::now() + command.time_limit;
  bool killed = false;
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, WNOHANG, &usage) == 0) {
    drain(pipe[0], end.report);
    if (!killed && std::chrono::steady_clock::now() > deadline) {
      end.how = ChildEnd::How::kTimedOut;
      killed = kill(child, SIGKILL) == 0;
    } else if (!killed && !proceed()) {
      end.how = ChildEnd::How::kStopped;
      killed = kill(child, SIGKILL) == 0;
    }
    pollfd wait{pipe[0], POLLIN, 0};
    poll(&wait, 1, static_cast<int>(kTick.count()));
    // poll() returns at once for a closed pipe. The child is about to end, so this avoids a busy
    // loop.
    if ((wait.revents & POLLHUP) != 0) usleep(2000);
  }
  drain(pipe[0], end.report);
  close(pipe[0]);
  end.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  if (killed) {
    // A child that used little CPU time waited for a busy machine or was stopped by a signal.
    const bool busy = cpu_time(usage) < command.time_limit / 2;
    if (end.how == ChildEnd::How::kTimedOut && busy) end.how = ChildEnd::How::kDelayed;
    return end;
  }
  if (WIFEXITED(status)) {
    end.how = ChildEnd::How::kExited;
    end.exit_code = WEXITSTATUS(status);
  } else {
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    // The kernel also ends a child with SIGKILL at RLIMIT_CPU (sandbox.cpp).
    const bool used_up = end.signal == SIGKILL && cpu_time(usage) >= command.time_limit;
    end.how = used_up ? ChildEnd::How::kTimedOut : ChildEnd::How::kCrashed;
  }
  return end;
}

}  // namespace diaphane
