#include "common/socket_deadlines.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>

namespace diaphane {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

struct Pair {
  Pair() {
    std::array<int, 2> ends{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    ours = ends[0];
    theirs = ends[1];
  }
  ~Pair() {
    close(ours);
    close(theirs);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  int ours = -1;
  int theirs = -1;
};

TEST(SocketDeadlines, UnblocksReadAtTheDeadline) {
  SocketDeadlines deadlines;
  const Pair pair;
  const SocketDeadlines::Guard guard(deadlines, pair.ours, steady_clock::now() + 20ms);
  char byte = 0;
  EXPECT_EQ(recv(pair.ours, &byte, 1, 0), 0) << "the connection looks closed";
  EXPECT_TRUE(guard.passed());
}

TEST(SocketDeadlines, LaterDeadlineDoesNotDelayAnEarlierOne) {
  SocketDeadlines deadlines;
  const Pair patient;
  const Pair hurried;
  const SocketDeadlines::Guard later(deadlines, patient.ours, steady_clock::now() + 1h);
  const SocketDeadlines::Guard sooner(deadlines, hurried.ours, steady_clock::now() + 20ms);
  char byte = 0;
  EXPECT_EQ(recv(hurried.ours, &byte, 1, 0), 0);
  EXPECT_TRUE(sooner.passed());
  EXPECT_FALSE(later.passed());
}

TEST(SocketDeadlines, DestroyedGuardDoesNotShutDownItsConnection) {
  SocketDeadlines deadlines;
  const Pair pair;
  const Pair other;
  const auto deadline = steady_clock::now() + 200ms;
  { const SocketDeadlines::Guard guard(deadlines, pair.ours, deadline); }
  const SocketDeadlines::Guard guard(deadlines, other.ours, deadline);
  char byte = 0;
  EXPECT_EQ(recv(other.ours, &byte, 1, 0), 0) << "the deadline of both has passed";
  EXPECT_EQ(send(pair.theirs, "x", 1, 0), 1);
  EXPECT_EQ(recv(pair.ours, &byte, 1, 0), 1);
}

TEST(SocketDeadlines, DoesNotShutDownReusedDescriptor) {
  SocketDeadlines deadlines;
  Pair first;
  const SocketDeadlines::Guard guard(deadlines, first.ours, steady_clock::now() + 50ms);
  Pair second;
  // The library closes its socket, and another connection gets the same number.
  ASSERT_EQ(dup2(second.ours, first.ours), first.ours);
  const Pair other;
  const SocketDeadlines::Guard until(deadlines, other.ours, steady_clock::now() + 60ms);
  char byte = 0;
  EXPECT_EQ(recv(other.ours, &byte, 1, 0), 0);
  EXPECT_TRUE(guard.passed());
  EXPECT_EQ(send(second.theirs, "x", 1, 0), 1);
  EXPECT_EQ(recv(first.ours, &byte, 1, 0), 1);
}

}  // namespace
}  // namespace diaphane
