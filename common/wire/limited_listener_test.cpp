#include "common/wire/limited_listener.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "common/connect.h"
#include "common/fd.h"

namespace diaphane::wire {
namespace {

using namespace std::chrono_literals;

PeerAddress peer(std::uint8_t last) {
  PeerAddress address{};
  address[15] = last;
  return address;
}

Fd open_socket() { return Fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)); }

struct UnfinishedHandshakesTest : testing::Test {
  bool admit(std::uint8_t address, const Fd& socket) {
    return unfinished.admit(peer(address), socket.get(), now);
  }

  UnfinishedHandshakes unfinished{{.total = 4, .per_address = 2, .deadline = 10s}};
  UnfinishedHandshakes::TimePoint now = UnfinishedHandshakes::TimePoint{} + 1h;
  std::vector<Fd> sockets;
};

TEST_F(UnfinishedHandshakesTest, LimitsEachAddressAndTheTotal) {
  for (int i = 0; i < 6; ++i) sockets.push_back(open_socket());
  EXPECT_TRUE(admit(1, sockets[0]));
  EXPECT_TRUE(admit(1, sockets[1]));
  EXPECT_FALSE(admit(1, sockets[2])) << "a third of one address";
  EXPECT_TRUE(admit(2, sockets[2]));
  EXPECT_TRUE(admit(3, sockets[3]));
  EXPECT_FALSE(admit(4, sockets[4])) << "a fifth in total";
  EXPECT_EQ(unfinished.count(), 4U);
}

TEST_F(UnfinishedHandshakesTest, ForgetsConnectionsAfterTheDeadline) {
  for (int i = 0; i < 3; ++i) sockets.push_back(open_socket());
  EXPECT_TRUE(admit(1, sockets[0]));
  EXPECT_TRUE(admit(1, sockets[1]));
  now += 10s;
  EXPECT_FALSE(admit(1, sockets[2])) << "the server needs a moment to close them";
  now += 3s;
  EXPECT_TRUE(admit(1, sockets[2]));
  EXPECT_EQ(unfinished.count(), 1U);
}

TEST_F(UnfinishedHandshakesTest, ForgetsClosedConnectionsEvenIfTheirDescriptorIsUsedAgain) {
  std::optional<Fd> first(open_socket()), second(open_socket());
  EXPECT_TRUE(admit(1, *first));
  EXPECT_TRUE(admit(1, *second));
  const int number = second->get();
  second.reset();
  const Fd other = open_socket();
  ASSERT_EQ(other.get(), number);
  EXPECT_TRUE(admit(1, other));
  EXPECT_EQ(unfinished.count(), 2U);
  now += 1s;
  const Fd third = open_socket();
  EXPECT_FALSE(admit(1, third)) << "both are open";
}

TEST_F(UnfinishedHandshakesTest, StrangersDoNotKeepKnownAddressesOut) {
  for (int i = 0; i < 12; ++i) sockets.push_back(open_socket());
  unfinished.know(peer(8), now);
  unfinished.know(peer(9), now);
  for (std::uint8_t i = 0; i < 4; ++i) EXPECT_TRUE(admit(i, sockets[i]));
  EXPECT_FALSE(admit(7, sockets[4])) << "a fifth stranger";
  EXPECT_TRUE(admit(8, sockets[4]));
  EXPECT_TRUE(admit(8, sockets[5]));
  EXPECT_FALSE(admit(8, sockets[6])) << "known addresses have a limit too";
  EXPECT_TRUE(admit(9, sockets[6]));
}

TEST_F(UnfinishedHandshakesTest, ForgetsTheLeastRecentAddress) {
  for (int i = 0; i < 6; ++i) sockets.push_back(open_socket());
  PeerAddress other{};
  for (std::size_t i = 0; i <= UnfinishedHandshakes::kMostKnown; ++i) {
    other[0] = static_cast<std::uint8_t>(i >> 8);
    other[1] = static_cast<std::uint8_t>(i);
    now += 1ms;
    unfinished.know(other, now);
  }
  for (std::uint8_t i = 1; i <= 4; ++i) EXPECT_TRUE(admit(i, sockets[i]));
  EXPECT_FALSE(admit(0, sockets[5])) << "the first one is a stranger again";
  EXPECT_TRUE(unfinished.admit(other, sockets[5].get(), now));
}

TEST(ParsePeer, ReadsTheNamesThatGrpcGives) {
  PeerAddress four{};
  four[10] = four[11] = 0xff;
  four[12] = 10;
  four[15] = 7;
  EXPECT_EQ(parse_peer("ipv4:10.0.0.7:1234"), four);
  PeerAddress six{};
  six[0] = 0xfd;
  six[15] = 1;
  EXPECT_EQ(parse_peer("ipv6:%5Bfd00::1%5D:1234"), six);
  EXPECT_EQ(parse_peer("ipv6:[fd00::1]:1234"), six);
  for (const char* none : {"", "unix:", "unix:/run/x:1", "ipv4:x:1", "ipv4:1.2.3.4", "ipv6:"}) {
    EXPECT_EQ(parse_peer(none), std::nullopt) << none;
  }
}

/// Keeps the connections that it gets.
class Server {
 public:
  explicit Server(UnfinishedHandshakes::Limits limits, const std::string& host = "127.0.0.1") {
    auto opened = LimitedListener::open(host, 0, limits);
    if (!opened) throw std::runtime_error(opened.error().message);
    listener = std::move(*opened);
    listener->start([this](int socket) {
      sockets.emplace_back(socket);
      ++taken;
    });
  }
  ~Server() { listener->stop(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  Fd connect(const std::string& host = "127.0.0.1") const {
    return connect_tcp(host + ":" + std::to_string(listener->port()), 5s);
  }

  std::unique_ptr<LimitedListener> listener;
  std::vector<Fd> sockets;
  std::atomic<int> taken{0};
};

bool ends(const Fd& client) {
  char byte = 0;
  for (int i = 0; i < 100; ++i) {
    const auto got = ::recv(client.get(), &byte, 1, 0);
    if (got == 0 || (got < 0 && errno == ECONNRESET)) return true;
    std::this_thread::sleep_for(50ms);
  }
  return false;
}

TEST(LimitedListener, ClosesConnectionsAboveTheLimitAtOnce) {
  const Server server({.total = 3, .per_address = 2});
  const Fd first = server.connect(), second = server.connect(), third = server.connect();
  ASSERT_TRUE(first && second && third);
  EXPECT_TRUE(ends(third));
  EXPECT_EQ(server.taken, 2);
}

TEST(LimitedListener, ListensForBothFamiliesOnTheWildcardAddress) {
  for (const char* host : {"0.0.0.0", "[::]"}) {
    const Server server({}, host);
    EXPECT_TRUE(server.connect("127.0.0.1")) << host;
    // A machine may have no IPv6.
    const Fd six(::socket(AF_INET6, SOCK_STREAM, 0));
    sockaddr_in6 own{};
    own.sin6_family = AF_INET6;
    own.sin6_addr = in6addr_loopback;
    if (six && ::bind(six.get(), reinterpret_cast<sockaddr*>(&own), sizeof own) == 0) {
      EXPECT_TRUE(server.connect("[::1]")) << host;
    }
  }
}

TEST(LimitedListener, RefusesATakenPortAndFreesItWhenItStops) {
  auto first = LimitedListener::open("127.0.0.1", 0, {});
  ASSERT_TRUE(first);
  const std::uint16_t port = (*first)->port();
  const auto second = LimitedListener::open("127.0.0.1", port, {});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  (*first)->stop();
  EXPECT_TRUE(LimitedListener::open("127.0.0.1", port, {}));
}

TEST(LimitedListener, RefusesAnUnknownHost) {
  EXPECT_FALSE(LimitedListener::open("no-such-host.invalid", 0, {}));
}

}  // namespace
}  // namespace diaphane::wire
