#include "common/sandbox/supervisor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace diaphane {
namespace {

using How = ChildEnd::How;

/// Runs a shell as the child, in place of a child that does anything.
ChildEnd shell(
    const std::string& script, std::chrono::milliseconds limit = std::chrono::seconds(20),
    const std::function<bool()>& should_continue = [] { return true; }) {
  const int input = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int output = open("/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  ChildCommand command{"/bin/sh", {"-c", script}, input, output, limit};
  auto end = run_child(command, should_continue);
  EXPECT_TRUE(end.has_value());
  close(input);
  close(output);
  return end.value_or(ChildEnd());
}

TEST(Supervisor, ReturnsReportAndExitCode) {
  const ChildEnd end = shell("printf hello >&5; exit 3");
  EXPECT_EQ(end.how, How::kExited);
  EXPECT_EQ(end.exit_code, 3);
  EXPECT_EQ(end.report, "hello");
  EXPECT_GT(end.peak_bytes, 100000u);
}

TEST(Supervisor, ReportsCrashWithItsSignal) {
  const ChildEnd end = shell("kill -SEGV $$");
  EXPECT_EQ(end.how, How::kCrashed);
  EXPECT_EQ(end.signal, SIGSEGV);
}

TEST(Supervisor, KillsChildAtTheTimeLimit) {
  // A busy machine may give the child too little CPU time to blame it, but not every time.
  How how = How::kDelayed;
  for (int tries = 0; tries < 20 && how == How::kDelayed; ++tries) {
    const auto before = std::chrono::steady_clock::now();
    how = shell("trap '' TERM INT; while :; do :; done", std::chrono::milliseconds(300)).how;
    EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(10));
  }
  EXPECT_EQ(how, How::kTimedOut);
}

TEST(Supervisor, ChildWithoutCpuTimeIsRetried) {
  EXPECT_EQ(shell("kill -STOP $$", std::chrono::milliseconds(300)).how, How::kDelayed);
}

TEST(Supervisor, StopRequestEndsTheChild) {
  int asked = 0;
  EXPECT_EQ(shell("while :; do :; done", std::chrono::seconds(20), [&] { return ++asked < 4; }).how,
            How::kStopped);
}

TEST(Supervisor, TruncatesEndlessReport) {
  const ChildEnd end = shell("while :; do echo xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx >&5; done",
                             std::chrono::milliseconds(500));
  EXPECT_TRUE(end.how == How::kTimedOut || end.how == How::kDelayed);
  EXPECT_LE(end.report.size(), kLongestReport + 1);
}

TEST(Supervisor, ChildInheritsNoEnvironmentAndNoDescriptors) {
  setenv("DIAPHANE_POSTGRES", "postgresql://user:secret@host", 1);
  const int leaked = open("/etc/hostname", O_RDONLY);  // on purpose without O_CLOEXEC
  const ChildEnd end = shell("{ export -p; ls -l /proc/self/fd; } >&5");
  close(leaked);
  unsetenv("DIAPHANE_POSTGRES");
  EXPECT_EQ(end.report.find("secret"), std::string::npos);
  EXPECT_EQ(end.report.find("hostname"), std::string::npos) << end.report;
  EXPECT_NE(end.report.find("/dev/null"), std::string::npos) << "0 to 2 are open";
}

TEST(Supervisor, MissingProgramExitsWith127) {
  const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
  auto end =
      run_child({"/no/such/program", {}, null, null, std::chrono::seconds(5)}, [] { return true; });
  close(null);
  ASSERT_TRUE(end.has_value());
  EXPECT_EQ(end->exit_code, 127);
}

}  // namespace
}  // namespace diaphane
