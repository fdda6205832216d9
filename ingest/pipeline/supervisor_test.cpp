#include "ingest/pipeline/supervisor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "ingest/pipeline/report.h"

namespace diaphane::ingest {
namespace {

using How = ChildEnd::How;

/// Runs a shell as the child, in place of a child that does anything.
ChildEnd shell(
    const std::string& script, std::chrono::milliseconds limit = std::chrono::seconds(20),
    const std::function<bool()>& go_on = [] { return true; }) {
  const int input = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int output = open("/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  ChildCommand command{"/bin/sh", {"-c", script}, input, output, limit};
  auto end = run_child(command, go_on);
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

TEST(Supervisor, ChildThatGotNoCpuTimeIsNotToBlame) {
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
  EXPECT_FALSE(read_report(end.report).has_value());
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

TEST(Report, RoundTrips) {
  Verdict verdict = refused("too_few_slices", "Too few slices: 3.");
  auto again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_FALSE(again->ready);
  EXPECT_EQ(again->code, verdict.code);
  EXPECT_EQ(again->text, verdict.text);
  verdict = {};
  verdict.ready = true;
  verdict.header.size = {4, 3, 2};
  verdict.header.repairs = {"one slice was there twice"};
  again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->ready);
  EXPECT_EQ(again->header.size, verdict.header.size);
  EXPECT_EQ(again->header.repairs, verdict.header.repairs);
}

TEST(Report, RefusesReportsOfACompromisedChild) {
  for (const std::string bad :
       {std::string(), std::string("{"), std::string("[]"), std::string("{\"code\":\"x\"}"),
        std::string(R"({"code":"Robert'); DROP TABLE","text":"x"})"),
        std::string(R"({"code":"x","text":"M\u00fcller"})"),
        std::string(R"({"code":"x","text":"a\nb"})"), std::string(R"({"code":1,"text":2})"),
        std::string(R"({"header":"{}"})"), std::string(R"({"header":{"size":[1,1,1]}})"),
        R"({"code":"x","text":)" + std::string(250'000, '[') + std::string(250'000, ']') + "}",
        R"({"code":"x","text":")" + std::string(5000, 'y') + "\"}"}) {
    EXPECT_FALSE(read_report(bad).has_value()) << bad.substr(0, 200);
  }
  Verdict verdict;
  verdict.ready = true;
  verdict.header.size = {4, 3, 2};
  verdict.header.repairs.assign(50, "x");
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "a flood of repairs";
  verdict.header.repairs = {"M\xc3\xbcller"};
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "no text of ours";
  verdict.header.repairs = {};
  verdict.header.content_hash = "blake2b:00";
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "the hash is the parent's to say";
}

}  // namespace
}  // namespace diaphane::ingest
