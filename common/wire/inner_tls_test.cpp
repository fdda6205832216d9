// TLS between programs, with real certificates: which peers are accepted, which are refused, and
// renewal.
#include "common/wire/inner_tls.h"

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/health_check_service_interface.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <filesystem>
#include <thread>

#include "common/wire/grpc_credentials.h"
#include "common/wire/tls_tunnel.h"
#include "tests/support/common/test_authority.h"

namespace diaphane::wire {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::milliseconds;
using std::chrono::seconds;

InnerTls with(TlsFiles files, std::string name = {}) {
  return {.files = std::move(files), .name = std::move(name)};
}

/// A gRPC server that answers health checks, with `tls`.
class Server {
 public:
  explicit Server(const InnerTls& tls) {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", server_credentials(tls), &port_);
    builder.RegisterAsyncGenericService(&none_);
    queue_ = builder.AddCompletionQueue();
    server_ = builder.BuildAndStart();
  }
  ~Server() {
    server_->Shutdown(std::chrono::system_clock::now());
    queue_->Shutdown();
    void* tag = nullptr;
    bool ok = false;
    while (queue_->Next(&tag, &ok)) {
    }
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  int port_ = 0;
  grpc::AsyncGenericService none_;
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  std::unique_ptr<grpc::Server> server_;
};

bool connects(const std::string& address, const InnerTls& tls, seconds patience = seconds(2)) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 200);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 200);
  const auto channel = open_channel(address, tls, channel_credentials(tls), arguments);
  return channel->WaitForConnected(std::chrono::system_clock::now() + patience);
}

class GrpcTls : public ::testing::Test {
 protected:
  Authority ours, others;
  TlsFiles server_files = ours.issue("server", "DNS:renderd");
  TlsFiles client_files = ours.issue("client", "DNS:api");
  Server server{with(server_files)};
};

TEST_F(GrpcTls, ConnectsPeersOfTheSameAuthority) {
  EXPECT_TRUE(connects(server.address(), with(client_files, "renderd"), seconds(20)));
}

TEST_F(GrpcTls, RefusesServerWithWrongNameOrAuthority) {
  EXPECT_FALSE(connects(server.address(), with(client_files, "postgres")));
  EXPECT_FALSE(connects(server.address(), with(client_files))) << "it is not for 127.0.0.1";
  TlsFiles misled = client_files;
  misled.ca = others.path("ca.pem");
  EXPECT_FALSE(connects(server.address(), with(misled, "renderd")));
}

TEST_F(GrpcTls, RefusesExpiredSelfSignedAndClientOnlyCertificates) {
  for (const TlsFiles& files :
       {ours.issue("expired", "DNS:renderd", -1), ours.issue_to_itself("itself", "DNS:renderd"),
        ours.issue("no-server", "DNS:renderd", 2, "clientAuth")}) {
    const Server false_server(with(files));
    EXPECT_FALSE(connects(false_server.address(), with(client_files, "renderd")))
        << files.certificate;
  }
  const Server right(with(ours.issue("right", "DNS:renderd", 2, "serverAuth")));
  EXPECT_TRUE(connects(right.address(), with(client_files, "renderd"), seconds(20)));
}

TEST_F(GrpcTls, DistrustsServerAfterItsCertificateIsReplacedByAForeignOne) {
  ASSERT_TRUE(connects(server.address(), with(client_files, "renderd"), seconds(20)));
  const TlsFiles foreign = others.issue("foreign", "DNS:renderd");
  std::filesystem::rename(foreign.key, server_files.key);
  std::filesystem::rename(foreign.certificate, server_files.certificate);
  const auto until = std::chrono::steady_clock::now() + seconds(10 * kLookedAt);
  bool trusted = true;
  while (trusted && std::chrono::steady_clock::now() < until) {
    trusted = connects(server.address(), with(client_files, "renderd"));
  }
  EXPECT_FALSE(trusted);
}

// With TLS 1.3, a client learns only after its own handshake that the server refuses its
// certificate, so the connection is checked again a second later.
bool is_answered(const std::string& address, const InnerTls& tls) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto channel = open_channel(address, tls, channel_credentials(tls), arguments);
  const auto until = std::chrono::system_clock::now() + seconds(3);
  if (!channel->WaitForConnected(until)) return false;
  // The connection must survive the server's decision.
  grpc_connectivity_state state = channel->GetState(false);
  return state == GRPC_CHANNEL_READY &&
         !channel->WaitForStateChange(state, std::chrono::system_clock::now() + seconds(1));
}

TEST_F(GrpcTls, RefusesClientOfAnotherAuthorityOrWithoutTls) {
  EXPECT_TRUE(is_answered(server.address(), with(client_files, "renderd")));
  TlsFiles foreign = others.issue("client", "DNS:api");
  foreign.ca = ours.path("ca.pem");
  EXPECT_FALSE(is_answered(server.address(), with(foreign, "renderd")));
  EXPECT_FALSE(is_answered(server.address(), InnerTls{}));
}

TEST_F(GrpcTls, ReloadsRenewedCertificate) {
  ASSERT_TRUE(connects(server.address(), with(client_files, "renderd"), seconds(20)));
  const TlsFiles renewed = ours.issue("renewed", "DNS:renamed");
  std::filesystem::rename(renewed.key, server_files.key);
  std::filesystem::rename(renewed.certificate, server_files.certificate);
  EXPECT_TRUE(connects(server.address(), with(client_files, "renamed"), seconds(4 * kLookedAt)));
}

TEST(PlainAddress, AllowsOnlyLoopbackUnlessExplicitlyAllowed) {
  for (const char* here : {"127.0.0.1:1", "127.9.9.9", "localhost:80", "[::1]:80", "::1",
                           "unix:/run/diaphane/redis.sock"}) {
    EXPECT_TRUE(is_this_machine(here)) << here;
    EXPECT_TRUE(may_be_plain(here, {})) << here;
  }
  for (const char* there : {"10.0.0.1:1", "redis:6379", "[fd00::1]:80", "127.0.0.1.evil.test:1",
                            "0.0.0.0", "localhost.evil.test:1", "::", ""}) {
    EXPECT_FALSE(is_this_machine(there)) << there;
    EXPECT_FALSE(may_be_plain(there, {})) << there;
    EXPECT_TRUE(may_be_plain(there, {.plain_allowed = true})) << there;
  }
  EXPECT_NE(may_be_plain("10.0.0.1:1", {}).error().message.find("--inner-plain"),
            std::string::npos);
}

TEST(PlainAddress, OpensNoPlainChannelToAnotherMachine) {
  const auto channel =
      open_channel("192.0.2.1:1", {}, channel_credentials({}), grpc::ChannelArguments());
  EXPECT_FALSE(channel->WaitForConnected(std::chrono::system_clock::now() + milliseconds(100)));
}

std::vector<std::string> mistakes_of(const TlsFiles& files, Role own,
                                     const std::string& roles = "1") {
  ConfigReader in({"--inner-tls-ca", files.ca, "--inner-tls-certificate", files.certificate,
                   "--inner-tls-key", files.key, "--inner-tls-roles", roles},
                  {});
  (void)read_inner_tls(in, own);
  return in.mistakes();
}

TEST(InnerTlsSettings, RefusesIncompleteOrMismatchedFiles) {
  const Authority ours;
  const std::string api = "DNS:one,URI:" + role_uri(Role::kApi);
  const TlsFiles one = ours.issue("one", api), two = ours.issue("two", api);
  const auto mistakes = [](const TlsFiles& files) { return mistakes_of(files, Role::kApi).size(); };
  EXPECT_EQ(mistakes(one), 0U);
  EXPECT_EQ(mistakes({one.ca, one.certificate, two.key}), 1U);
  EXPECT_EQ(mistakes({one.ca, one.certificate, ""}), 1U);
  EXPECT_EQ(mistakes({"/none", one.certificate, one.key}), 1U);
  EXPECT_EQ(mistakes({one.ca, one.key, one.key}), 1U);
}

TEST(InnerTlsSettings, RefusesACertificateWithoutTheRoleOfTheProgramAndSaysWhatToDo) {
  const Authority ours;
  const TlsFiles none = ours.issue("none", "DNS:one,URI:spiffe://elsewhere/gateway");
  const TlsFiles api = ours.issue("api", "DNS:one,URI:spiffe://diaphane/api");
  const TlsFiles both =
      ours.issue("both", "URI:spiffe://diaphane/api,URI:spiffe://diaphane/gateway");
  const auto without = mistakes_of(none, Role::kGateway);
  ASSERT_EQ(without.size(), 1U);
  EXPECT_NE(without[0].find("none.pem has no role, but this program needs the role gateway"),
            std::string::npos)
      << without[0];
  EXPECT_NE(without[0].find("spiffe://diaphane/gateway"), std::string::npos);
  EXPECT_NE(without[0].find("--inner-tls-roles 0"), std::string::npos);
  const auto wrong = mistakes_of(api, Role::kGateway);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_NE(wrong[0].find("api.pem has the role api"), std::string::npos) << wrong[0];
  EXPECT_TRUE(mistakes_of(api, Role::kApi).empty());
  EXPECT_TRUE(mistakes_of(both, Role::kGateway).empty());
  EXPECT_TRUE(mistakes_of(none, Role::kGateway, "0").empty());
}

TEST(RedisSetting, ReportsMalformedAddressesAndMissingTls) {
  const auto mistakes = [](const std::string& address) {
    ConfigReader in({"--redis", address}, {});
    EXPECT_EQ(read_redis(in, {}), address);
    return in.mistakes();
  };
  EXPECT_TRUE(mistakes("127.0.0.1:6379").empty());
  EXPECT_TRUE(mistakes("unix:/run/redis.sock").empty());
  ASSERT_EQ(mistakes("redis").size(), 1U);
  EXPECT_EQ(mistakes("redis")[0],
            "--redis: must be unix:PATH or host:port with a port from 1 to 65535");
  EXPECT_EQ(mistakes("127.0.0.1:0").size(), 1U);
  EXPECT_EQ(mistakes("rediss://127.0.0.1:6379").size(), 1U);
}

/// Echoes data over TLS to clients with certificates of the CA in `files`, one client after the
/// other.
class Echo {
 public:
  explicit Echo(const TlsFiles& files) : context_(asio::ssl::context::tls_server) {
    context_.load_verify_file(files.ca);
    context_.use_certificate_chain_file(files.certificate);
    context_.use_private_key_file(files.key, asio::ssl::context::pem);
    context_.set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
    thread_ = std::thread([this] { serve(); });
  }
  ~Echo() {
    ending_ = true;
    boost::system::error_code ignored;
    tcp::socket wake(io_);
    wake.connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  Echo(const Echo&) = delete;
  Echo& operator=(const Echo&) = delete;
  int port() const { return acceptor_.local_endpoint().port(); }

 private:
  void serve() {
    while (true) {
      asio::ssl::stream<tcp::socket> one(io_, context_);
      acceptor_.accept(one.next_layer());
      if (ending_) return;
      boost::system::error_code fault;
      one.handshake(asio::ssl::stream_base::server, fault);
      std::array<char, 4096> heard{};
      while (!fault) {
        const std::size_t bytes = one.read_some(asio::buffer(heard), fault);
        if (!fault) asio::write(one, asio::buffer(heard.data(), bytes), fault);
      }
    }
  }

  asio::io_context io_;
  asio::ssl::context context_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

/// Returns whether all bytes come back before the stream ends.
bool says_back(int local, std::size_t bytes) {
  const std::string said(bytes, 'x');
  std::thread writer([&] {
    for (std::size_t sent = 0; sent < said.size();) {
      const auto now = ::send(local, said.data() + sent, said.size() - sent, MSG_NOSIGNAL);
      if (now <= 0) return;
      sent += static_cast<std::size_t>(now);
    }
  });
  std::string heard(bytes, '\0');
  std::size_t got = 0;
  while (got < bytes) {
    const auto now = ::recv(local, heard.data() + got, bytes - got, 0);
    if (now <= 0) break;
    got += static_cast<std::size_t>(now);
  }
  ::shutdown(local, SHUT_RDWR);
  writer.join();
  ::close(local);
  return heard == said;
}

TEST(TlsTunnel, CarriesDataInBothDirections) {
  const Authority ours;
  const Echo server(ours.issue("server", "IP:127.0.0.1,DNS:localhost"));
  TlsTunnels tunnels(ours.issue("client", "DNS:api"));
  for (const char* host : {"127.0.0.1", "localhost"}) {
    const auto local = tunnels.open(host, server.port(), seconds(20));
    ASSERT_TRUE(local) << local.error().message;
    EXPECT_TRUE(says_back(*local, 3'000'000));
  }
}

TEST(TlsTunnel, RefusesServerWithWrongNameOrAuthority) {
  const Authority ours, others;
  const TlsFiles client = ours.issue("client", "DNS:api");
  const Echo misnamed(ours.issue("server", "DNS:elsewhere,IP:127.0.0.2"));
  EXPECT_FALSE(TlsTunnels(client).open("127.0.0.1", misnamed.port(), seconds(20)));
  TlsFiles foreign = others.issue("server", "IP:127.0.0.1");
  foreign.ca = ours.path("ca.pem");
  const Echo stranger(foreign);
  const auto refused = TlsTunnels(client).open("127.0.0.1", stranger.port(), seconds(20));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
}

TEST(TlsTunnel, RefusesExpiredSelfSignedAndClientOnlyCertificates) {
  const Authority ours;
  const TlsFiles client = ours.issue("client", "DNS:api");
  for (const TlsFiles& files :
       {ours.issue("expired", "IP:127.0.0.1", -1), ours.issue_to_itself("itself", "IP:127.0.0.1"),
        ours.issue("no-server", "IP:127.0.0.1", 2, "clientAuth")}) {
    const Echo false_server(files);
    EXPECT_FALSE(TlsTunnels(client).open("127.0.0.1", false_server.port(), seconds(20)))
        << files.certificate;
  }
}

TEST(TlsTunnel, EndsWhenTheServerRefusesTheClientCertificate) {
  const Authority ours, others;
  const Echo server(ours.issue("server", "IP:127.0.0.1"));
  TlsFiles foreign = others.issue("client", "DNS:api");
  foreign.ca = ours.path("ca.pem");
  TlsTunnels tunnels(foreign);
  const auto local = tunnels.open("127.0.0.1", server.port(), seconds(20));
  EXPECT_TRUE(!local || !says_back(*local, 10));
}

TEST(TlsTunnel, ConnectionAttemptTimesOut) {
  const Authority ours;
  asio::io_context io;
  tcp::acceptor silent(io, {asio::ip::make_address("127.0.0.1"), 0});
  TlsTunnels tunnels(ours.issue("client", "DNS:api"));
  EXPECT_FALSE(tunnels.open("127.0.0.1", silent.local_endpoint().port(), milliseconds(50)));
  EXPECT_FALSE(tunnels.open("127.0.0.1", 1, seconds(20)));
  std::filesystem::remove(ours.path("client.key"));
  EXPECT_FALSE(tunnels.open("127.0.0.1", silent.local_endpoint().port(), milliseconds(50)));
}

}  // namespace
}  // namespace diaphane::wire
