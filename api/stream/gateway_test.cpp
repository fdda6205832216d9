#include "api/stream/gateway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "api/stream/worker_error_curves.h"
#include "api/stream/worker_stills.h"
#include "tests/support/api/gateway_fixture.h"

namespace diaphane::api::stream {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using testing::ElementsAre;

TEST_F(GatewayTest, ForwardsMessagesUnchangedInBothDirections) {
  FakeWorker worker;
  start();
  TestViewer one = viewer();
  ASSERT_TRUE(one.enter(places_.issue(worker.address())));
  EXPECT_EQ(one.answered_subprotocol(), "diaphane.v1");
  for (const std::string& message :
       {std::string("\0\xff\r\n", 4), std::string(64 * 1024, 'm'), std::string()}) {
    ASSERT_TRUE(one.send(message));
    EXPECT_EQ(one.receive(), message);
  }
  wait_for_metric("diaphane_stream_messages_total{direction=\"to_viewer\"} 3");
  wait_for_metric("diaphane_stream_attached 1");
}

TEST_F(GatewayTest, KeepsMessageOrderUnderBackPressure) {
  FakeWorker worker;
  start();
  const auto one = attached(worker);
  std::thread sender([&] {
    for (int i = 0; i < 500; ++i) one->send(std::to_string(i));
  });
  sender.join();
  for (int i = 0; i < 500; ++i) ASSERT_EQ(one->receive(), std::to_string(i));
}

TEST_F(GatewayTest, OpenCarriesTheStateOfTheSession) {
  FakeWorker worker;
  start();
  const std::string ticket = places_.issue(worker.address());
  std::string session, volume;
  places_.change(ticket, [&](Attachment& attachment) {
    diaphane::v1::Scene scene;
    scene.mutable_phase()->set_g(0.25);
    attachment.scene = scene.SerializeAsString();
    attachment.input_seq = 12;
    attachment.width = 640;
    attachment.height = 480;
    session = attachment.session.id;
    volume = attachment.session.data_set_id;
  });
  TestViewer one = viewer();
  ASSERT_TRUE(one.enter(ticket));
  one.send("x");
  ASSERT_TRUE(one.receive());
  const diaphane::v1::Open open = worker.last_open();
  EXPECT_EQ(open.session_id(), session);
  EXPECT_EQ(open.volume_id(), volume);
  EXPECT_EQ(open.placement(), 7u);
  EXPECT_EQ(open.scene().phase().g(), 0.25);
  EXPECT_EQ(open.input_seq(), 12u);
  EXPECT_EQ(open.viewport().width(), 640u);
}

TEST_F(GatewayTest, DisabledLinkDisconnectsOnlyItsGuests) {
  FakeWorker worker;
  start();
  const std::string person = places_.issue(worker.address());
  const std::string guest = places_.issue(worker.address());
  const std::string another = places_.issue(worker.address());
  places_.change(guest, [](Attachment& attachment) { attachment.link = "ended soon"; });
  places_.change(another, [](Attachment& attachment) { attachment.link = "stays"; });
  TestViewer one = viewer(), two = viewer(), three = viewer();
  ASSERT_TRUE(one.enter(person));
  ASSERT_TRUE(two.enter(guest));
  ASSERT_TRUE(three.enter(another));
  for (TestViewer* each : {&one, &two, &three}) {
    each->send("here");
    ASSERT_EQ(each->receive(), "here");
  }
  places_.end_link("ended soon");
  EXPECT_EQ(two.close_code(), 4410);
  for (TestViewer* each : {&one, &three}) {
    each->send("still here");
    EXPECT_EQ(each->receive(), "still here");
  }
}

TEST_F(GatewayTest, RefusesInvalidHandshakeWithoutUsingTheTicket) {
  FakeWorker worker;
  start();
  const std::string ticket = places_.issue(worker.address());
  const std::string target = "/stream?ticket=" + ticket;
  const auto status = [&](const std::string& wanted, const char* origin, const char* subprotocol) {
    return viewer().status_of_handshake(wanted, origin, subprotocol);
  };
  EXPECT_EQ(status(target, "https://evil.example", "diaphane.v1"), 403u);
  EXPECT_EQ(status(target, "", "diaphane.v1"), 403u);
  EXPECT_EQ(status(target, TestViewer::kOrigin, ""), 400u);
  EXPECT_EQ(status(target, TestViewer::kOrigin, "diaphane.v2"), 400u);
  EXPECT_EQ(status("/other?ticket=" + ticket, TestViewer::kOrigin, "diaphane.v1"), 400u);
  EXPECT_EQ(status("/stream?ticket=abc", TestViewer::kOrigin, "diaphane.v1"), 400u);
  // None of them used the ticket.
  EXPECT_TRUE(viewer().enter(ticket));
  wait_for_metric("diaphane_stream_refusals_total{reason=\"origin\"} 2");
}

TEST_F(GatewayTest, UnknownOrUsedTicketClosesWith4401) {
  FakeWorker worker;
  start();
  const std::string ticket = places_.issue(worker.address());
  TestViewer first = viewer(), second = viewer(), third = viewer();
  ASSERT_TRUE(first.enter(ticket));
  // The ticket is checked after the handshake, so only an answer shows that the first has used it.
  first.send("here");
  ASSERT_EQ(first.receive(), "here");
  ASSERT_TRUE(second.enter(ticket));
  EXPECT_EQ(second.close_code(), 4401);
  ASSERT_TRUE(third.enter(std::string(64, '0')));
  EXPECT_EQ(third.close_code(), 4401);
  first.send("still here");
  EXPECT_EQ(first.receive(), "still here");
}

TEST_F(GatewayTest, EndedSessionClosesWith4404AndUnavailableRedisWith4503) {
  FakeWorker worker;
  start();
  const std::string gone = places_.issue(worker.address());
  places_.end_all_sessions();
  TestViewer first = viewer(), second = viewer();
  ASSERT_TRUE(first.enter(gone));
  EXPECT_EQ(first.close_code(), 4404);
  const std::string ticket = places_.issue(worker.address());
  places_.set_away(true);
  ASSERT_TRUE(second.enter(ticket));
  EXPECT_EQ(second.close_code(), 4503);
}

TEST_F(GatewayTest, MapsWorkerStatusToCloseCode) {
  start();
  using grpc::StatusCode;
  const std::pair<StatusCode, int> cases[] = {
      {StatusCode::OK, 1000},        {StatusCode::INVALID_ARGUMENT, 4400},
      {StatusCode::NOT_FOUND, 4404}, {StatusCode::RESOURCE_EXHAUSTED, 4429},
      {StatusCode::ABORTED, 4409},   {StatusCode::UNAVAILABLE, 4503},
      {StatusCode::INTERNAL, 4503},  {StatusCode::PERMISSION_DENIED, 1011},
  };
  for (const auto& [status, code] : cases) {
    FakeWorker worker(FakeWorker::ending(status));
    TestViewer one = viewer();
    ASSERT_TRUE(one.enter(places_.issue(worker.address())));
    EXPECT_EQ(one.close_code(), code) << "gRPC status " << status;
  }
  EXPECT_TRUE(places_.lost_workers().empty()) << "a worker that can be reached is not lost";
}

TEST_F(GatewayTest, DisplacedVisitorClosesWith4411) {
  FakeWorker needed(FakeWorker::displacing());
  start();
  TestViewer one = viewer();
  ASSERT_TRUE(one.enter(places_.issue(needed.address())));
  EXPECT_EQ(one.close_code(), 4411);
  EXPECT_TRUE(places_.refused_sessions().empty());
}

TEST_F(GatewayTest, SessionMovesToAnotherWorkerOnOutOfMemory) {
  FakeWorker full(FakeWorker::without_memory()),
      crowded(FakeWorker::ending(grpc::StatusCode::RESOURCE_EXHAUSTED));
  start();
  TestViewer one = viewer(), two = viewer(), three = viewer();
  ASSERT_TRUE(one.enter(places_.issue(full.address())));
  EXPECT_EQ(one.close_code(), 4503) << "asks for another place at once";
  EXPECT_THAT(places_.refused_sessions(), ElementsAre("known|worker|7"));
  ASSERT_TRUE(two.enter(places_.issue(crowded.address())));
  EXPECT_EQ(two.close_code(), 4429) << "too many viewers: the session stays where it is";
  const std::string ticket = places_.issue(full.address());
  places_.change(ticket, [](Attachment& a) { a.session.worker_id = "other"; });
  ASSERT_TRUE(three.enter(ticket));
  EXPECT_EQ(three.close_code(), 4503);
  EXPECT_EQ(places_.refused_sessions().size(), 2u);
  EXPECT_TRUE(places_.lost_workers().empty()) << "it lives, and continues with the others";
}

TEST_F(GatewayTest, MovedOrEndedSessionIsNotReportedAsTakenOver) {
  start();
  FakeWorker worker([](grpc::ServerContext&, FakeWorker::Stream& stream) {
    diaphane::v1::AttachRequest request;
    stream.Read(&request);
    return grpc::Status(grpc::StatusCode::ABORTED, "");
  });
  TestViewer moved = viewer(), ended = viewer();
  ASSERT_TRUE(moved.enter(places_.issue(worker.address())));
  places_.move_all_sessions_to("another");
  moved.send("now");
  EXPECT_EQ(moved.close_code(), 4503);
  ASSERT_TRUE(ended.enter(places_.issue(worker.address())));
  std::this_thread::sleep_for(milliseconds(100));
  places_.end_all_sessions();
  ended.send("now");
  EXPECT_EQ(ended.close_code(), 4404);
}

TEST_F(GatewayTest, LastMessagesOfWorkerArriveBeforeTheClose) {
  start();
  FakeWorker worker([](grpc::ServerContext&, FakeWorker::Stream& stream) {
    diaphane::v1::AttachReply reply;
    for (int i = 0; i < 10; ++i) {
      reply.set_server_message(std::to_string(i));
      stream.Write(reply);
    }
    return grpc::Status(grpc::StatusCode::ABORTED, "");
  });
  TestViewer one = viewer();
  ASSERT_TRUE(one.enter(places_.issue(worker.address())));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(one.receive(), std::to_string(i));
  EXPECT_EQ(one.close_code(), 4409);
}

TEST_F(GatewayTest, RemovesDeadWorkerBeforeClosingTheViewer) {
  FakeWorker worker;
  start();
  const auto one = attached(worker);
  worker.die();
  EXPECT_EQ(one->close_code(), 4503);
  EXPECT_THAT(places_.lost_workers(), ElementsAre("worker|one"));
}

TEST_F(GatewayTest, RemovesUnreachableWorker) {
  std::string address;
  {
    FakeWorker dead;
    address = dead.address();
  }
  start({.attach = seconds(60)});
  TestViewer one = viewer();
  const auto begin = steady_clock::now();
  ASSERT_TRUE(one.enter(places_.issue(address)));
  EXPECT_EQ(one.close_code(), 4503);
  EXPECT_LT(steady_clock::now() - begin, seconds(30)) << "it waited for the time limit";
  EXPECT_THAT(places_.lost_workers(), ElementsAre("worker|one"));
}

TEST_F(GatewayTest, AttachTimesOutOnUnresponsiveWorker) {
  boost::asio::io_context io;
  boost::asio::ip::tcp::acceptor mute(io, {boost::asio::ip::make_address("127.0.0.1"), 0});
  start({.attach = milliseconds(300)});
  TestViewer one = viewer();
  ASSERT_TRUE(
      one.enter(places_.issue("127.0.0.1:" + std::to_string(mute.local_endpoint().port()))));
  EXPECT_EQ(one.close_code(), 4503);
}

TEST_F(GatewayTest, DisconnectsFromWorkerWithoutHeartbeat) {
  FakeWorker worker;
  start({.watch = milliseconds(100)});
  const auto one = attached(worker);
  std::this_thread::sleep_for(milliseconds(400));
  one->send("still here");
  EXPECT_EQ(one->receive(), "still here");
  places_.set_alive(false);
  EXPECT_EQ(one->close_code(), 4503);
}

TEST_F(GatewayTest, StreamsContinueWhileRedisIsUnavailable) {
  FakeWorker worker;
  start({.watch = milliseconds(50)});
  const auto one = attached(worker);
  places_.set_away(true);
  std::this_thread::sleep_for(milliseconds(400));
  one->send("still here");
  EXPECT_EQ(one->receive(), "still here");
}

TEST_F(GatewayTest, StoppingClosesEachViewerWith1001) {
  FakeWorker worker;
  start();
  const auto one = attached(worker), two = attached(worker);
  const auto begin = steady_clock::now();
  std::thread stopping([&] { gateway_->stop(seconds(60)); });
  EXPECT_EQ(one->close_code(), 1001);
  EXPECT_EQ(two->close_code(), 1001);
  stopping.join();
  EXPECT_LT(steady_clock::now() - begin, seconds(30)) << "it waited for the grace period";
  EXPECT_TRUE(worker.calls_ended(2));
}

TEST_F(GatewayTest, StoppingWaitsAtMostTheGracePeriod) {
  FakeWorker worker(FakeWorker::flood(300'000));
  start();
  TestViewer stalled = viewer(4096);
  ASSERT_TRUE(stalled.enter(places_.issue(worker.address())));
  std::this_thread::sleep_for(milliseconds(200));
  const auto begin = steady_clock::now();
  gateway_->stop(milliseconds(300));
  EXPECT_LT(steady_clock::now() - begin, seconds(8)) << "a stalled viewer is given up after 10 s";
}

TEST_F(GatewayTest, StartReportsOccupiedPortAndInvalidUrl) {
  start();
  prometheus::Registry registry;
  const auto taken = Gateway::start({.port = gateway_->port(), .public_url = "https://x"}, places_,
                                    places_, places_, registry);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::kUnavailable);
  prometheus::Registry another;
  EXPECT_EQ(Gateway::start({.public_url = "x"}, places_, places_, places_, another).error().code,
            ErrorCode::kInvalid);
}

TEST_F(GatewayTest, StillFallsBackToNextWorkerWhenTheFirstIsUnavailable) {
  FakeWorker worker;
  std::string dead_address;
  {
    FakeWorker dead;
    dead_address = dead.address();
  }
  WorkerStills stills(places_);
  const StillRequest request{.data_set_id = "volume", .preset = "bone"};
  places_.alive_workers = {{"b", worker.address(), "one", 4, 3, false, {}},
                           {"a", dead_address, "one", 4, 0, false, {"volume"}}};
  EXPECT_EQ(stills.render(request).value_or(""), "jpeg of volume bone");
  places_.alive_workers = {{"b", worker.address(), "one", 4, 3, true, {}}};
  EXPECT_EQ(stills.render(request).error().code, ErrorCode::kUnavailable) << "it drains";
  places_.alive_workers = {{"b", worker.address(), "one", 4, 3, false, {}}};
  EXPECT_EQ(stills.render({.data_set_id = "volume", .preset = "missing"}).error().code,
            ErrorCode::kNotFound);
}

TEST_F(GatewayTest, TheErrorCurveComesFromTheWorkerOfTheSession) {
  FakeWorker worker;
  WorkerErrorCurves curves(places_);
  places_.alive_workers = {{"a", worker.address(), "one", 4, 3, false, {}}};
  const auto curve = curves.find("a", "session");
  ASSERT_TRUE(curve);
  EXPECT_EQ(curve->epoch, 7u);
  ASSERT_EQ(curve->points.size(), 1u);
  EXPECT_EQ(curve->points[0].samples, 16u);
  EXPECT_EQ(curve->points[0].seconds, 0.5);
  EXPECT_EQ(curve->points[0].error, 0.25);
  EXPECT_EQ(curves.find("a", "missing").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(curves.find("a", "refused").error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(curves.find("another", "session").error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace diaphane::api::stream
