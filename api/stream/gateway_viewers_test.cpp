// Viewers that read slowly, stop reading, send too much, are too many, or vanish, without affecting
// other viewers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <thread>

#include "tests/support/api/gateway_fixture.h"

namespace diaphane::api::stream {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using testing::HasSubstr;

TEST_F(GatewayTest, ClosesOnTextOversizedAndTooFrequentMessages) {
  FakeWorker worker;
  start({.messages_per_second = 100});
  const auto text = attached(worker), large = attached(worker), many = attached(worker);
  text->send_text("hello");
  EXPECT_EQ(text->close_code(), 4400);
  large->send(std::string(64 * 1024 + 1, 'x'));
  EXPECT_EQ(large->close_code(), 1009);
  for (int i = 0; i < 300; ++i) many->send("x");
  EXPECT_EQ(many->close_code(), 4429);
}

TEST_F(GatewayTest, ClosesStalledViewerWithoutDelayingOthers) {
  FakeWorker flood(FakeWorker::flood(300'000)), worker;
  start({.write = milliseconds(3000)});
  TestViewer stalled = viewer(4096);
  ASSERT_TRUE(stalled.enter(places_.issue(flood.address())));
  const auto other = attached(worker);
  const auto begin = steady_clock::now();
  steady_clock::duration slowest{0};
  while (steady_clock::now() - begin < milliseconds(3500)) {
    const auto sent = steady_clock::now();
    ASSERT_TRUE(other->send("ping"));
    ASSERT_EQ(other->receive(), "ping");
    slowest = std::max(slowest, steady_clock::now() - sent);
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_LT(slowest, milliseconds(2000)) << "it waited for the stalled one to be given up";
  wait_for_metric("diaphane_stream_slow_viewers_total 1");
  EXPECT_TRUE(flood.calls_ended(1)) << "its worker is freed";
}

TEST_F(GatewayTest, SlowViewerAppliesBackPressureWithoutLoss) {
  std::atomic<int> written = 0;
  FakeWorker worker([&](grpc::ServerContext&, FakeWorker::Stream& stream) {
    diaphane::v1::AttachReply reply;
    for (int i = 0; i < 200; ++i) {
      reply.set_server_message(std::to_string(i) + std::string(100'000, ' '));
      if (!stream.Write(reply)) break;
      ++written;
    }
    return grpc::Status::OK;
  });
  start();
  TestViewer one = viewer(4096);
  ASSERT_TRUE(one.enter(places_.issue(worker.address())));
  std::this_thread::sleep_for(milliseconds(700));
  EXPECT_LT(written, 150) << "20 MB must not pile up anywhere";
  for (int i = 0; i < 200; ++i) {
    const auto message = one.receive();
    ASSERT_TRUE(message);
    EXPECT_EQ(std::stoi(*message), i);
  }
  EXPECT_EQ(one.close_code(), 1000);
}

TEST_F(GatewayTest, LastMessagesOfViewerReachTheWorker) {
  FakeWorker* self = nullptr;
  FakeWorker worker([&](grpc::ServerContext&, FakeWorker::Stream& stream) {
    diaphane::v1::AttachRequest request;
    while (stream.Read(&request)) {
      self->note(request.client_message());
      std::this_thread::sleep_for(milliseconds(20));
    }
    return grpc::Status::OK;
  });
  self = &worker;
  start();
  {
    TestViewer one = viewer();
    ASSERT_TRUE(one.enter(places_.issue(worker.address())));
    for (int i = 0; i < 20; ++i) one.send(std::to_string(i));
    one.leave();
  }
  EXPECT_EQ(worker.received(20).size(), 20u);
  EXPECT_TRUE(worker.calls_ended(1));
}

TEST_F(GatewayTest, ResetConnectionEndsTheCallToTheWorker) {
  FakeWorker worker;
  start();
  {
    const auto one = attached(worker);
    one->tcp().set_option(boost::asio::socket_base::linger(true, 0));
    one->tcp().close();
  }
  EXPECT_TRUE(worker.calls_ended(1));
  wait_for_metric("diaphane_stream_connections 0");
}

TEST_F(GatewayTest, ClosesIdleViewerThatDoesNotAnswerPings) {
  FakeWorker worker;
  start({.idle = milliseconds(400)});
  const auto mute = attached(worker), answering = attached(worker);
  std::thread reader([&] { EXPECT_FALSE(answering->receive(milliseconds(1200))) << "only pings"; });
  wait_for_metric("diaphane_stream_attached 1");
  reader.join();
}

TEST_F(GatewayTest, LimitsConnectionsInTotalAndPerUser) {
  FakeWorker worker;
  start({.connections = 3, .connections_per_user = 1});
  const std::string user = new_id();
  const auto first = attached(worker, user);
  TestViewer same = viewer();
  ASSERT_TRUE(same.enter(places_.issue(worker.address(), user)));
  EXPECT_EQ(same.close_code(), 4429);
  wait_for_metric("diaphane_stream_connections 1");
  const auto second = attached(worker), third = attached(worker);
  EXPECT_FALSE(viewer().enter(places_.issue(worker.address())));
  first->leave();
  wait_for_metric("diaphane_stream_connections 2");
  attached(worker, user);
}

TEST_F(GatewayTest, EndsSlowOrOversizedHandshake) {
  start({.handshake = milliseconds(300)});
  boost::asio::io_context io;
  const auto talk = [&](const std::string& text, milliseconds between) {
    boost::asio::ip::tcp::socket socket(io);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"), gateway_->port()});
    boost::system::error_code error;
    for (std::size_t at = 0; at < text.size() && !error; at += 1024) {
      boost::asio::write(socket, boost::asio::buffer(text.substr(at, 1024)), error);
      std::this_thread::sleep_for(between);
    }
    std::string answer;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
    return answer.substr(0, answer.find('\r'));
  };
  const auto begin = steady_clock::now();
  EXPECT_EQ(talk("", milliseconds(0)), "");
  EXPECT_EQ(talk("GET /stream HTTP/1.1\r\n", milliseconds(0)), "");
  EXPECT_LT(steady_clock::now() - begin, seconds(60)) << "others are kept for 40 s each";
  EXPECT_EQ(talk("GET / HTTP/1.1\r\nHost: x\r\n\r\n", milliseconds(0)),
            "HTTP/1.1 426 Upgrade Required");
  EXPECT_EQ(talk("\x16\x03\x01 garbage\r\n\r\n", milliseconds(0)), "HTTP/1.1 400 Bad Request");
  EXPECT_THAT(talk("GET / HTTP/1.1\r\nX: " + std::string(20'000, 'x'), milliseconds(0)),
              HasSubstr("431"));
  wait_for_metric("diaphane_stream_connections 0");
}

}  // namespace
}  // namespace diaphane::api::stream
