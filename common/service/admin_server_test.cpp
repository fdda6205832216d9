#include "common/service/admin_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>

#include "tests/support/common/claimed_port.h"

namespace diaphane::service {
namespace {

/// Returns a connection on which the text was sent, or -1 if nothing listens on the port.
int send_to(std::uint16_t port, const std::string& request) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool sent = connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
                    write(fd, request.data(), request.size()) >= 0;
  if (sent) return fd;
  close(fd);
  return -1;
}

/// Returns everything that arrives until the peer closes the connection.
std::string read_all(int fd) {
  std::string answer;
  char buffer[4096];
  for (ssize_t got; (got = read(fd, buffer, sizeof buffer)) > 0;) answer.append(buffer, got);
  close(fd);
  return answer;
}

std::string get(std::uint16_t port, const std::string& path) {
  const int fd = send_to(port, "GET " + path + " HTTP/1.1\r\nHost: x\r\n\r\n");
  return fd < 0 ? "" : read_all(fd);
}

TEST(AdminServer, ReadinessFollowsChecksAndHealthDoesNot) {
  std::atomic<bool> database{true};
  const ClaimedPort claimed = ClaimedPort::take().value();
  AdminServer::Options options;
  options.port = claimed.number();
  options.program = "test";
  options.checks = {{"database", [&] { return database.load(); }}};
  options.details = [] { return std::string(R"({"engine":"cpu"})"); };
  const std::uint16_t port = options.port;
  auto server = AdminServer::start(std::move(options));
  ASSERT_TRUE(server.has_value()) << server.error().message;
  EXPECT_NE(get(port, "/readyz").find("200 OK"), std::string::npos);
  EXPECT_NE(get(port, "/readyz").find(R"("engine":"cpu")"), std::string::npos);
  database = false;
  EXPECT_NE(get(port, "/readyz").find("503"), std::string::npos);
  EXPECT_NE(get(port, "/healthz").find("200 OK"), std::string::npos);
  database = true;
  (*server)->set_draining();
  EXPECT_NE(get(port, "/readyz").find("503"), std::string::npos);
  EXPECT_NE(get(port, "/metrics").find("diaphane_start_time_seconds"), std::string::npos);
}

TEST(AdminServer, ReportsOccupiedPort) {
  const ClaimedPort claimed = ClaimedPort::take().value();
  AdminServer::Options first;
  first.port = claimed.number();
  AdminServer::Options second = first;
  auto a = AdminServer::start(std::move(first));
  ASSERT_TRUE(a.has_value());
  auto b = AdminServer::start(std::move(second));
  ASSERT_FALSE(b.has_value());
  EXPECT_EQ(b.error().code, ErrorCode::kUnavailable);
}

TEST(AdminServer, UnfinishedRequestsDoNotDelayProbes) {
  const ClaimedPort claimed = ClaimedPort::take().value();
  AdminServer::Options options;
  options.port = claimed.number();
  const std::uint16_t port = options.port;
  auto server = AdminServer::start(std::move(options));
  ASSERT_TRUE(server.has_value());
  // More connections than the server holds, so it closes the oldest.
  std::array<int, 100> unfinished{};
  for (int& fd : unfinished) fd = send_to(port, "GET /readyz HTTP/1.1\r\nHost: ");
  const auto before = std::chrono::steady_clock::now();
  EXPECT_NE(get(port, "/readyz").find("200 OK"), std::string::npos);
  // A server with two threads that wait 2 s for each request would take 100 s.
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(20));
  for (const int fd : unfinished) EXPECT_EQ(read_all(fd), "") << "each of them is ended";
}

TEST(AdminServer, RefusesUnknownPathsMethodsAndOversizedRequests) {
  const ClaimedPort claimed = ClaimedPort::take().value();
  AdminServer::Options options;
  options.port = claimed.number();
  const std::uint16_t port = options.port;
  auto server = AdminServer::start(std::move(options));
  ASSERT_TRUE(server.has_value());
  EXPECT_NE(get(port, "/").find("404"), std::string::npos);
  EXPECT_NE(read_all(send_to(port, "POST /metrics HTTP/1.1\r\nHost: x\r\n\r\n")).find("405"),
            std::string::npos);
  const std::string endless = "GET /" + std::string(20'000, 'x');
  EXPECT_EQ(read_all(send_to(port, endless)), "");
  EXPECT_NE(get(port, "/healthz?a=b").find("200 OK"), std::string::npos);
}

TEST(AdminServer, StopsImmediately) {
  const ClaimedPort claimed = ClaimedPort::take().value();
  AdminServer::Options options;
  options.port = claimed.number();
  const std::uint16_t port = options.port;
  auto server = AdminServer::start(std::move(options));
  ASSERT_TRUE(server.has_value());
  ASSERT_NE(get(port, "/healthz").find("200 OK"), std::string::npos);
  const auto before = std::chrono::steady_clock::now();
  server->reset();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(1));
  EXPECT_EQ(get(port, "/healthz"), "");
}

}  // namespace
}  // namespace diaphane::service
