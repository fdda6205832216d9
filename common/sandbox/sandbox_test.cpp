#include "common/sandbox/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <sstream>
#include <thread>
#include <vector>

namespace diaphane {
namespace {

constexpr int kDid = 10;      // the attempt succeeded
constexpr int kRefused = 11;  // the attempt failed, and the process continues
constexpr int kNoSandbox = 12;
/// Limits each child's life with SIGALRM, whatever a broken sandbox lets it wait for.
constexpr unsigned kChildSeconds = 60;

/// Descriptors that a child has as 3 and 4; -1: none.
struct Placed {
  int input = -1, output = -1;
};

/// Returns how a process ends that attempts something inside the sandbox: an exit code, or minus
/// the signal.
int inside(const std::function<int()>& act, const SandboxLimits& limits = {},
           const Placed& placed = {}) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(kChildSeconds);
    if (placed.input >= 0 && dup2(placed.input, 20) == 20) dup2(20, 3);
    if (placed.output >= 0 && dup2(placed.output, 21) == 21) dup2(21, 4);
    if (!enter_sandbox(limits)) _exit(kNoSandbox);
    _exit(act());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

int refused_if(bool failed) { return failed ? kRefused : kDid; }

class Sandbox : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers reserve terabytes and open files of their own";
#endif
  }
};

TEST_F(Sandbox, AllowsComputationAndOpenFiles) {
  int pipe_fds[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  const int file = open("/etc/hostname", O_RDONLY);
  const Placed placed{file, pipe_fds[1]};
  EXPECT_EQ(inside(
                [&] {
                  std::vector<double> numbers(1 << 20, 1.5);
                  char letter = 0;
                  const bool well = read(3, &letter, 1) == 1 && write(4, &letter, 1) == 1 &&
                                    lseek(3, 0, SEEK_SET) == 0 && numbers[77] == 1.5;
                  return well ? kDid : kRefused;
                },
                {}, placed),
            kDid);
}

TEST_F(Sandbox, ReadsOnlyTheInputAndWritesOnlyTheOutputs) {
  int pipe_fds[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  const Placed placed{open("/etc/hostname", O_RDONLY), pipe_fds[1]};
  const int other = fcntl(open("/etc/hostname", O_RDWR), F_DUPFD, 20);
  char letter = 'x';
  EXPECT_EQ(inside([&] { return refused_if(read(other, &letter, 1) < 0); }, {}, placed), -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(read(4, &letter, 1) < 0); }, {}, placed), -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(write(other, &letter, 1) < 0); }, {}, placed), -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(write(3, &letter, 1) < 0); }, {}, placed), kRefused)
      << "it is open for reading only";
  close(other);
}

TEST_F(Sandbox, RefusesToOpenFiles) {
  for (const char* path : {"/etc/passwd", "/proc/self/environ", "/etc/hostname", "/"}) {
    EXPECT_EQ(inside([&] { return refused_if(open(path, O_RDONLY) < 0 && errno == EACCES); }),
              kRefused);
  }
}

TEST_F(Sandbox, RefusesToCreateChangeOrRemoveFiles) {
  std::string path = (std::filesystem::temp_directory_path() / "diaphane-sandbox-XXXXXX").string();
  const int made = mkstemp(path.data());
  ASSERT_GE(made, 0);
  EXPECT_EQ(inside([&] { return refused_if(open(path.c_str(), O_WRONLY) < 0); }), kRefused);
  EXPECT_EQ(inside([&] { return refused_if(creat((path + "2").c_str(), 0600) < 0); }), -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(unlink(path.c_str()) != 0); }), -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(rename(path.c_str(), (path + "3").c_str()) != 0); }),
            -SIGSYS);
  EXPECT_EQ(inside([&] { return refused_if(chmod(path.c_str(), 0777) != 0); }), -SIGSYS);
  EXPECT_TRUE(std::filesystem::exists(path));
  close(made);
  unlink(path.c_str());
}

TEST_F(Sandbox, RefusesSockets) {
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK}) {
    EXPECT_EQ(inside([&] { return refused_if(socket(family, SOCK_STREAM, 0) < 0); }), -SIGSYS)
        << family;
  }
}

TEST_F(Sandbox, RefusesProgramsProcessesAndThreads) {
  EXPECT_EQ(inside([] {
              char name[] = "/bin/true";
              char* const arguments[] = {name, nullptr};
              execv(name, arguments);
              return kRefused;
            }),
            -SIGSYS);
  // fork(3) is clone, which is refused, and the process continues.
  EXPECT_EQ(inside([] {
              const pid_t child = fork();
              if (child == 0) _exit(0);
              return refused_if(child < 0);
            }),
            kRefused);
  EXPECT_EQ(inside([] {
              try {
                std::thread([] {}).join();
                return kDid;
              } catch (const std::system_error&) {
                return kRefused;
              }
            }),
            kRefused);
}

TEST_F(Sandbox, RefusesToSignalOtherProcesses) {
  const pid_t parent = getpid();
  EXPECT_EQ(inside([&] { return refused_if(kill(parent, 0) != 0); }), -SIGSYS);
  EXPECT_EQ(inside([] { return refused_if(kill(1, 0) != 0); }), -SIGSYS);
}

TEST_F(Sandbox, AllowsOnlyItsOwnAbort) {
  const pid_t parent = getpid();
  EXPECT_EQ(inside([] {
              abort();
              return kDid;
            }),
            -SIGABRT);
  EXPECT_EQ(inside([&] { return refused_if(syscall(SYS_tgkill, parent, parent, SIGABRT) != 0); }),
            -SIGSYS);
  EXPECT_EQ(inside([] { return refused_if(raise(SIGTERM) != 0); }), -SIGSYS);
}

TEST_F(Sandbox, RefusesExecutableMemory) {
  const auto map = [](int protection) {
    return mmap(nullptr, 4096, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
  };
  EXPECT_EQ(inside([&] { return map(PROT_READ | PROT_WRITE) ? kDid : kRefused; }), kDid);
  EXPECT_EQ(inside([&] { return map(PROT_READ | PROT_EXEC) ? kDid : kRefused; }), -SIGSYS);
  EXPECT_EQ(inside([&] {
              void* page = mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
              return mprotect(page, 4096, PROT_READ | PROT_EXEC) == 0 ? kDid : kRefused;
            }),
            -SIGSYS);
}

TEST_F(Sandbox, RefusesPrivilegedAndUnknownSystemCalls) {
  EXPECT_EQ(inside([] { return refused_if(setuid(0) != 0); }), -SIGSYS);
  // By number, to include calls without a function in the C library.
  for (const long call : {SYS_ptrace,
                          SYS_process_vm_readv,
                          SYS_mount,
                          SYS_unshare,
                          SYS_setns,
                          SYS_chroot,
                          SYS_bpf,
                          SYS_io_uring_setup,
                          SYS_memfd_create,
                          SYS_userfaultfd,
                          SYS_perf_event_open,
                          SYS_keyctl,
                          SYS_pidfd_open,
                          SYS_kexec_load,
                          SYS_init_module,
                          SYS_open_by_handle_at,
                          SYS_execveat,
                          SYS_fork,
                          SYS_vfork,
                          SYS_connect,
                          SYS_bind,
                          SYS_sendto,
                          SYS_socketpair,
                          SYS_dup2,
                          SYS_sendfile,
                          SYS_splice,
                          SYS_prctl,
                          SYS_seccomp,
                          SYS_setrlimit,
                          SYS_openat2,
                          SYS_linkat,
                          SYS_symlinkat,
                          SYS_mkdirat,
                          SYS_truncate,
                          SYS_utimensat,
                          SYS_inotify_init}) {
    EXPECT_EQ(inside([&] { return refused_if(syscall(call, 0, 0, 0, 0, 0, 0) < 0); }), -SIGSYS)
        << call;
  }
  EXPECT_EQ(inside([] { return refused_if(syscall(100000L) < 0); }), -SIGSYS) << "not yet invented";
}

TEST_F(Sandbox, LimitsAreFinal) {
  // Read from outside while the child is stopped inside.
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    alarm(kChildSeconds);
    dup2(ready[1], 4);
    if (!enter_sandbox({})) _exit(kNoSandbox);
    if (write(4, "x", 1) != 1) _exit(kRefused);
    for (;;) sched_yield();
  }
  close(ready[1]);  // a child that ends before it stops closes the pipe
  char letter = 0;
  ASSERT_EQ(read(ready[0], &letter, 1), 1);
  const auto text_of = [&](const char* name) {
    std::ifstream in("/proc/" + std::to_string(child) + "/" + name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string status = text_of("status"), limits = text_of("limits");
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_NE(status.find("NoNewPrivs:\t1"), std::string::npos);
  EXPECT_NE(status.find("Seccomp:\t2"), std::string::npos);
  const auto both = [&](const char* what, const std::string& number) {
    const std::size_t at = limits.find(what);
    if (at == std::string::npos) return false;
    std::istringstream line(limits.substr(at + 26, 45));
    std::string soft, hard;
    line >> soft >> hard;
    return soft == number && hard == number;
  };
  EXPECT_TRUE(both("Max core file size", "0"));
  EXPECT_TRUE(both("Max open files", "6"));
  EXPECT_TRUE(both("Max processes", "0"));
  EXPECT_TRUE(both("Max locked memory", "0"));
  EXPECT_TRUE(both("Max address space", std::to_string(std::uint64_t{4} << 30))) << limits;
  EXPECT_TRUE(both("Max cpu time", "300"));
  EXPECT_TRUE(both("Max file size", std::to_string(std::uint64_t{2} << 30)));
}

TEST_F(Sandbox, MemoryLimitRaisesBadAlloc) {
  SandboxLimits limits;
  limits.memory_bytes = std::uint64_t{1} << 30;
  const auto ask = [](std::size_t bytes) {
    return [bytes] {
      try {
        const std::vector<char> much(bytes, 1);
        return much[bytes / 2] == 1 ? kDid : kRefused;
      } catch (const std::bad_alloc&) {
        return kRefused;
      }
    };
  };
  EXPECT_EQ(inside(ask(std::size_t{100} << 20), limits), kDid);
  EXPECT_EQ(inside(ask(std::size_t{2} << 30), limits), kRefused);
}

TEST_F(Sandbox, LimitsOutputAndCpuTime) {
  SandboxLimits limits;
  limits.output_bytes = 1000;
  std::string path = (std::filesystem::temp_directory_path() / "diaphane-sandbox-XXXXXX").string();
  const int file = mkstemp(path.data());
  unlink(path.c_str());
  EXPECT_EQ(inside(
                [&] {
                  const std::vector<char> data(5000);
                  while (write(4, data.data(), data.size()) > 0) {
                  }
                  return kRefused;
                },
                limits, {-1, file}),
            -SIGXFSZ);
  close(file);
  limits.cpu_seconds = 1;
  EXPECT_EQ(inside(
                [] {
                  for (;;) asm volatile("");
                  return kDid;
                },
                limits),
            -SIGKILL)
      << "the hard limit is the soft one";
}

}  // namespace
}  // namespace diaphane
