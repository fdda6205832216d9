#include "ingest/pipeline/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <thread>
#include <vector>

namespace diaphane::ingest {
namespace {

constexpr int kDid = 10;      // what was tried, worked
constexpr int kRefused = 11;  // it failed, and the process goes on
constexpr int kNoSandbox = 12;

/// How a process ends that tries something inside the sandbox: an exit code, or minus the signal.
int inside(const std::function<int()>& act, const SandboxLimits& limits = {}) {
  const pid_t child = fork();
  if (child == 0) {
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

TEST_F(Sandbox, ComputingReadingAndWritingWhatIsOpenGoesOn) {
  int pipe_fds[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  const int file = open("/etc/hostname", O_RDONLY);
  EXPECT_EQ(inside([&] {
              std::vector<double> numbers(1 << 20, 1.5);
              char letter = 0;
              const bool well = read(file, &letter, 1) == 1 &&
                                write(pipe_fds[1], &letter, 1) == 1 && numbers[77] == 1.5;
              return well ? kDid : kRefused;
            }),
            kDid);
}

TEST_F(Sandbox, NoFileCanBeOpened) {
  for (const char* path : {"/etc/passwd", "/proc/self/environ", "/etc/hostname", "/"}) {
    EXPECT_EQ(inside([&] { return refused_if(open(path, O_RDONLY) < 0 && errno == EACCES); }),
              kRefused);
  }
}

TEST_F(Sandbox, NoFileCanBeMadeChangedOrRemoved) {
  std::string path = (std::filesystem::temp_directory_path() / "diaphane-sandbox-XXXXXX").string();
  const int made = mkstemp(path.data());
  ASSERT_GE(made, 0);
  EXPECT_EQ(inside([&] { return refused_if(open(path.c_str(), O_WRONLY) < 0); }), kRefused);
  EXPECT_EQ(inside([&] { return refused_if(creat((path + "2").c_str(), 0600) < 0); }), kRefused);
  EXPECT_EQ(inside([&] { return refused_if(unlink(path.c_str()) != 0); }), kRefused);
  EXPECT_EQ(inside([&] { return refused_if(rename(path.c_str(), (path + "3").c_str()) != 0); }),
            kRefused);
  EXPECT_EQ(inside([&] { return refused_if(chmod(path.c_str(), 0777) != 0); }), kRefused);
  EXPECT_TRUE(std::filesystem::exists(path));
  close(made);
  unlink(path.c_str());
}

TEST_F(Sandbox, NoSocketCanBeMade) {
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK}) {
    EXPECT_EQ(inside([&] { return refused_if(socket(family, SOCK_STREAM, 0) < 0); }), -SIGSYS)
        << family;
  }
}

TEST_F(Sandbox, NoProgramCanBeStartedAndNoProcessMade) {
  EXPECT_EQ(inside([] {
              char name[] = "/bin/true";
              char* const arguments[] = {name, nullptr};
              execv(name, arguments);
              return kRefused;
            }),
            -SIGSYS);
  // fork(3) is clone: refused, and the process goes on.
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

TEST_F(Sandbox, NobodyElseCanBeSignalled) {
  const pid_t parent = getpid();
  EXPECT_EQ(inside([&] { return refused_if(kill(parent, 0) != 0); }), -SIGSYS);
  EXPECT_EQ(inside([] { return refused_if(kill(1, 0) != 0); }), -SIGSYS);
}

TEST_F(Sandbox, MemoryIsLimitedAndSaidByAnException) {
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

TEST_F(Sandbox, OutputAndTimeAreLimited) {
  SandboxLimits limits;
  limits.output_bytes = 1000;
  std::string path = (std::filesystem::temp_directory_path() / "diaphane-sandbox-XXXXXX").string();
  const int file = mkstemp(path.data());
  unlink(path.c_str());
  EXPECT_EQ(inside(
                [&] {
                  const std::vector<char> data(5000);
                  while (write(file, data.data(), data.size()) > 0) {
                  }
                  return kRefused;
                },
                limits),
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
}  // namespace diaphane::ingest
