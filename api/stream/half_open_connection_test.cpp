// A connection to a worker that silently drops everything: it does not close and gets no answer,
// while heartbeats continue.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <memory>
#include <thread>

#include "api/stream/gateway.h"
#include "api/stream/hub.h"
#include "tests/support/api/fake_stream_parts.h"
#include "tests/support/api/test_viewer.h"

namespace diaphane::api::stream {
namespace {

using boost::asio::ip::tcp;

/// Forwards bytes between a gateway and a worker until it is set to drop them.
class Line {
 public:
  explicit Line(const std::string& worker)
      : to_(boost::asio::ip::make_address("127.0.0.1"),
            static_cast<std::uint16_t>(std::stoi(worker.substr(worker.rfind(':') + 1)))) {
    accept();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Line() {
    io_.stop();
    thread_.join();
  }
  std::string address() const {
    return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  void swallow() { swallows_ = true; }

 private:
  struct Pair {
    explicit Pair(tcp::socket gateway) : left(std::move(gateway)), right(left.get_executor()) {}
    tcp::socket left, right;
    std::array<char, 65536> leftward{}, rightward{};
  };

  void accept() {
    acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (error) return;
      auto pair = std::make_shared<Pair>(std::move(socket));
      boost::system::error_code refused;
      pair->right.connect(to_, refused);
      if (!refused) {
        pass(pair, pair->left, pair->right, pair->rightward);
        pass(pair, pair->right, pair->left, pair->leftward);
      }
      accept();
    });
  }
  void pass(const std::shared_ptr<Pair>& pair, tcp::socket& from, tcp::socket& to,
            std::array<char, 65536>& buffer) {
    from.async_read_some(
        boost::asio::buffer(buffer),
        [this, pair, &from, &to, &buffer](boost::system::error_code error, std::size_t count) {
          boost::system::error_code broken;
          if (error) {
            to.shutdown(tcp::socket::shutdown_both, broken);
            return;
          }
          if (!swallows_) boost::asio::write(to, boost::asio::buffer(buffer.data(), count), broken);
          if (!broken) pass(pair, from, to, buffer);
        });
  }

  boost::asio::io_context io_;
  tcp::endpoint to_;
  tcp::acceptor acceptor_{io_, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  std::atomic<bool> swallows_ = false;
  std::thread thread_;
};

TEST(HalfOpenConnection, ClosesStreamWhenKeepaliveFails) {
  FakeWorker worker;
  Line line(worker.address());
  FakePlaces places;
  prometheus::Registry registry;
  auto gateway =
      Gateway::start({.public_url = TestViewer::kOrigin}, places, places, places, registry);
  ASSERT_TRUE(gateway);
  TestViewer viewer((*gateway)->port());
  ASSERT_TRUE(viewer.enter(places.issue(line.address())));
  viewer.send("hello");
  ASSERT_EQ(viewer.receive(), "hello");
  // Nothing is sent for longer than the interval between two checks, and a live connection is kept.
  EXPECT_FALSE(viewer.tcp().available());
  std::this_thread::sleep_for(std::chrono::seconds(6));
  viewer.send("still here");
  ASSERT_EQ(viewer.receive(), "still here");

  line.swallow();
  EXPECT_EQ(viewer.close_code(std::chrono::seconds(15)), 4503);
}

}  // namespace
}  // namespace diaphane::api::stream
