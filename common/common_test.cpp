#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/connect.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/result.h"
#include "common/try.h"
#include "tests/support/common/claimed_port.h"

namespace diaphane {
namespace {

TEST(Ids, GeneratesWellFormedUniqueIds) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = new_id();
    EXPECT_TRUE(is_id(id)) << id;
    EXPECT_TRUE(seen.insert(id).second);
  }
}

TEST(Ids, RefusesMalformedIds) {
  EXPECT_FALSE(is_id(""));
  EXPECT_FALSE(is_id("../../../../../../../../../etc/passwd!"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-00000000000G"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-0000000000000"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-00000000000A"));
}

TEST(ClaimedPort, IsExclusiveWhileItExists) {
  std::vector<ClaimedPort> held;
  std::set<std::uint16_t> numbers;
  for (int i = 0; i < 100; ++i) {
    auto port = ClaimedPort::take();
    ASSERT_TRUE(port) << port.error().message;
    EXPECT_TRUE(numbers.insert(port->number()).second);
    held.push_back(*std::move(port));
  }
  // Claims the mark like ./diaphane up (tools/devtool/ports.py).
  const std::string name = "diaphane-port-" + std::to_string(held.back().number());
  const auto could_be_chosen = [&] {
    const int mark = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path + 1, name.size());
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    const bool bound = bind(mark, reinterpret_cast<sockaddr*>(&address), size) == 0;
    close(mark);
    return bound;
  };
  EXPECT_FALSE(could_be_chosen());
  held.pop_back();
  EXPECT_TRUE(could_be_chosen());
}

/// Listens on the loopback address of a family. The descriptor is invalid if this machine does not
/// support the family.
struct Listening {
  explicit Listening(int family) : fd(::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_storage address{};
    address.ss_family = static_cast<sa_family_t>(family);
    socklen_t size = sizeof(sockaddr_in);
    if (family == AF_INET6) {
      reinterpret_cast<sockaddr_in6&>(address).sin6_addr = in6addr_loopback;
      size = sizeof(sockaddr_in6);
    } else {
      reinterpret_cast<sockaddr_in&>(address).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    }
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    ready = fd && ::bind(fd.get(), any, size) == 0 && ::listen(fd.get(), 1) == 0 &&
            ::getsockname(fd.get(), any, &size) == 0;
    port = std::to_string(ntohs(reinterpret_cast<sockaddr_in&>(address).sin_port));
  }
  Fd fd;
  bool ready = false;
  std::string port;
};

TEST(ConnectTcp, TriesEachAddressOfTheHost) {
  using namespace std::chrono_literals;
  const Listening four(AF_INET);
  ASSERT_TRUE(four.ready);
  EXPECT_TRUE(connect_tcp("127.0.0.1:" + four.port, 5s));
  EXPECT_TRUE(connect_tcp("localhost:" + four.port, 5s)) << "::1 may come first, where nobody is";
  if (const Listening six(AF_INET6); six.ready) EXPECT_TRUE(connect_tcp("[::1]:" + six.port, 5s));
  EXPECT_FALSE(connect_tcp("127.0.0.1:1", 5s));
  EXPECT_EQ(errno, ECONNREFUSED);
  EXPECT_FALSE(connect_tcp("127.0.0.1", 5s));
  EXPECT_FALSE(connect_tcp("no-such-host.invalid:80", 5s));
}

TEST(Config, OptionOverridesEnvironment) {
  ConfigReader in({"--api-port", "81"}, {{"DIAPHANE_API_PORT", "80"}, {"DIAPHANE_REDIS", "r:1"}});
  EXPECT_EQ(in.port("api-port", "REST"), 81);
  EXPECT_EQ(in.text("redis", "host:port"), "r:1");
  EXPECT_FALSE(in.finish("test").has_value());
}

TEST(Config, ReportsAllMistakesTogether) {
  ConfigReader in({"--api-port=99999", "--engine", "abacus"}, {});
  in.port("api-port", "REST");
  in.text("redis", "host:port");
  in.one_of("engine", "which", {"auto", "cpu", "cuda"}, "auto");
  EXPECT_EQ(in.finish("test"), kExitConfig);
  EXPECT_EQ(in.mistakes().size(), 3u);
}

TEST(Config, UnknownOptionIsUsageError) {
  ConfigReader in({"--nonsense", "1"}, {});
  EXPECT_EQ(in.finish("test"), kExitUsage);
}

Result<int> doubled(const Result<int>& number, int& evaluations) {
  const auto counted = [&]() -> const Result<int>& {
    ++evaluations;
    return number;
  };
  DIAPHANE_TRY(counted());
  return 2 * *number;
}

TEST(Try, ContinuesWithAValue) {
  int evaluations = 0;
  EXPECT_EQ(doubled(21, evaluations).value(), 42);
  EXPECT_EQ(evaluations, 1);
}

TEST(Try, CopiesErrorOfAVariable) {
  int evaluations = 0;
  const Result<int> failed = fail(ErrorCode::kNotFound, "There is no such number.", "number");
  const auto result = doubled(failed, evaluations);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(result.error().message, "There is no such number.");
  EXPECT_EQ(result.error().field, "number");
  EXPECT_EQ(failed.error().message, "There is no such number.");
  EXPECT_EQ(evaluations, 1);
}

TEST(Try, AcceptsVoidResults) {
  const auto step = [](bool works) -> Result<void> {
    if (!works) return fail(ErrorCode::kTooLarge, "Too large.");
    return {};
  };
  const auto steps = [&](bool second) -> Result<std::string> {
    if (true) DIAPHANE_TRY(step(true));
    DIAPHANE_TRY(step(second));
    return "done";
  };
  EXPECT_EQ(steps(true).value(), "done");
  EXPECT_EQ(steps(false).error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace diaphane
