// The whole worker over real gRPC, with the real CPU engine and a small volume.

#include "renderd/serve/grpc_server.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <future>
#include <map>
#include <thread>

#include "api/proto/worker.grpc.pb.h"
#include "common/wire/grpc_credentials.h"
#include "tests/support/common/test_authority.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using Stream = grpc::ClientReaderWriter<v1::AttachRequest, v1::AttachReply>;

// One Attach call like the gateway's, with a reading thread.
class Client {
 public:
  Client(v1::RenderWorker::StubInterface& stub, const v1::Open& open) {
    stream_ = stub.Attach(&context_);
    v1::AttachRequest request;
    *request.mutable_open() = open;
    stream_->Write(request);
    reader_ = std::thread([this] {
      v1::AttachReply reply;
      while (stream_->Read(&reply)) inbox.put(reply.server_message());
      status_ = stream_->Finish();
      inbox.end({ErrorCode::kInternal, status_.error_message(), {}});
    });
  }
  ~Client() {
    context_.TryCancel();
    reader_.join();
  }
  void say(const v1::ClientMessage& message) {
    v1::AttachRequest request;
    request.set_client_message(message.SerializeAsString());
    stream_->Write(request);
  }
  void hang_up() { stream_->WritesDone(); }
  void vanish() { context_.TryCancel(); }
  std::optional<v1::Frame> follow(const std::function<bool(const v1::Frame&)>& until) {
    for (;;) {
      const auto message = inbox.next_of(v1::ServerMessage::kFrame, 30s);
      if (!message) return std::nullopt;
      say(ack_message(message->frame().seq()));
      if (until(message->frame())) return message->frame();
    }
  }
  grpc::StatusCode status() {
    EXPECT_TRUE(inbox.ended());
    return status_.error_code();
  }

  Inbox inbox;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriterInterface<v1::AttachRequest, v1::AttachReply>> stream_;
  std::thread reader_;
  grpc::Status status_;
};

struct GrpcTest : testing::Test {
  explicit GrpcTest(GrpcServer::Options server_options = {}) {
    RenderWorker::Options options;
    options.volume_dir = store.path;
    options.host.slots = 2;
    options.runner.rules.target_error = 0.2;
    auto engine = make_engine(EngineChoice::kCpu, 2);
    worker = std::make_unique<RenderWorker>(options, std::move(*engine), metrics, clock);
    server = std::move(
        *GrpcServer::start(std::move(server_options), worker->host(), worker->stills(), metrics));
    channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                  grpc::InsecureChannelCredentials());
    stub = v1::RenderWorker::NewStub(channel);
  }
  ~GrpcTest() override {
    worker->stop();
    server->stop(500ms);
  }
  v1::Open open(const std::string& session = new_id()) {
    v1::Open open;
    open.set_viewer(v1::VIEWER_OWNER);
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(1);
    return open;
  }

  TestStore store;
  std::string volume = store.add_ball();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SystemClock clock;
  std::unique_ptr<RenderWorker> worker;
  std::unique_ptr<GrpcServer> server;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::RenderWorker::Stub> stub;
};

TEST_F(GrpcTest, StreamsRealImagesThatConvergeAndFollowInput) {
  Client viewer(*stub, open());
  viewer.say(hello_message(96));
  const auto config = viewer.inbox.next_of(v1::ServerMessage::kConfig);
  ASSERT_TRUE(config);
  EXPECT_EQ(config->config().engine(), "cpu");
  // 256 bins over the values of all voxels, because there are few.
  const auto& histogram = config->config().histogram();
  const auto& header = config->config().volume();
  EXPECT_EQ(histogram.minimum(), header.minimum());
  EXPECT_GE(histogram.minimum() + histogram.width() * histogram.counts_size(), header.maximum());
  std::uint64_t counted = 0;
  for (const std::uint32_t n : histogram.counts()) counted += n;
  EXPECT_EQ(counted, std::uint64_t{header.size(0)} * header.size(1) * header.size(2));
  const auto first = viewer.follow([](const v1::Frame& frame) { return frame.width() == 96; });
  ASSERT_TRUE(first);
  EXPECT_EQ(first->data().substr(0, 2), "\xff\xd8");
  const auto good = viewer.follow([](const v1::Frame& frame) { return frame.iteration() >= 16; });
  ASSERT_TRUE(good);
  EXPECT_TRUE(std::isfinite(good->error()));
  EXPECT_GT(good->render_us(), 0U);

  viewer.say(scene_message(7, turned(config->config().scene(), 100)));
  const auto moved = viewer.follow([](const v1::Frame& frame) { return frame.input_seq() == 7; });
  ASSERT_TRUE(moved);
  EXPECT_GT(moved->epoch(), good->epoch());
  const auto state = viewer.inbox.next(
      [](const v1::ServerMessage& message) { return message.state().converged(); }, 1ms);
  if (!state) {
    EXPECT_TRUE(viewer.follow([](const v1::Frame& frame) { return frame.error() <= 0.2; }));
  }
}

TEST_F(GrpcTest, SecondAttachTakesOverTheSession) {
  const v1::Open same = open();
  Client first(*stub, same);
  first.say(hello_message());
  ASSERT_TRUE(first.inbox.next_of(v1::ServerMessage::kFrame));
  Client second(*stub, same);
  second.say(hello_message());
  EXPECT_EQ(first.status(), grpc::StatusCode::ABORTED);
  EXPECT_TRUE(second.inbox.next_of(v1::ServerMessage::kConfig));
  EXPECT_TRUE(second.inbox.next_of(v1::ServerMessage::kFrame));
}

TEST_F(GrpcTest, MapsRefusalsToStatusCodes) {
  Client one(*stub, open());
  Client two(*stub, open());
  one.say(hello_message());
  two.say(hello_message());
  ASSERT_TRUE(one.inbox.next_of(v1::ServerMessage::kFrame));
  ASSERT_TRUE(two.inbox.next_of(v1::ServerMessage::kFrame));
  EXPECT_EQ(Client(*stub, open()).status(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  v1::Open wrong = open();
  wrong.set_volume_id("../secret");
  EXPECT_EQ(Client(*stub, wrong).status(), grpc::StatusCode::INVALID_ARGUMENT);
  two.hang_up();
  EXPECT_EQ(two.status(), grpc::StatusCode::OK);
  v1::Open unknown = open();
  unknown.set_volume_id(new_id());
  EXPECT_EQ(Client(*stub, unknown).status(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(GrpcTest, OversizedMessageEndsOnlyItsCall) {
  Client one(*stub, open());
  one.say(hello_message());
  ASSERT_TRUE(one.inbox.next_of(v1::ServerMessage::kFrame));
  Client two(*stub, open());
  v1::ClientMessage huge = hello_message();
  huge.mutable_scene()->mutable_scene()->add_lights()->set_name(std::string(2 << 20, 'x'));
  two.say(huge);
  EXPECT_NE(two.status(), grpc::StatusCode::OK);
  one.say(ack_message(1));
  EXPECT_TRUE(one.inbox.next_of(v1::ServerMessage::kFrame));
}

TEST_F(GrpcTest, ReconnectingViewerContinuesWithTheSameFilm) {
  const v1::Open same = open();
  std::uint64_t samples = 0;
  {
    Client viewer(*stub, same);
    viewer.say(hello_message());
    const auto frame = viewer.follow([](const v1::Frame& f) { return f.iteration() >= 8; });
    ASSERT_TRUE(frame);
    samples = frame->iteration();
    viewer.vanish();
  }
  Client back(*stub, same);
  back.say(hello_message());
  const auto frame = back.inbox.next_of(v1::ServerMessage::kFrame);
  ASSERT_TRUE(frame);
  EXPECT_GE(frame->frame().iteration(), samples);
}

TEST_F(GrpcTest, ReturnsTheErrorCurveOfASession) {
  const v1::Open session = open();
  Client viewer(*stub, session);
  viewer.say(hello_message());
  const auto frame = viewer.follow([](const v1::Frame& f) { return f.iteration() >= 16; });
  ASSERT_TRUE(frame);
  v1::ErrorCurveRequest request;
  request.set_session_id(session.session_id());
  v1::ErrorCurve curve;
  grpc::ClientContext context;
  const grpc::Status status = stub->GetErrorCurve(&context, request, &curve);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(curve.epoch(), frame->epoch());
  ASSERT_GE(curve.points_size(), 2);
  EXPECT_GE(curve.points().rbegin()->samples(), frame->iteration());
  EXPECT_LT(curve.points().rbegin()->error(), curve.points(0).error());
  EXPECT_GT(curve.points(0).seconds(), 0);

  request.set_session_id(new_id());
  grpc::ClientContext another;
  EXPECT_EQ(stub->GetErrorCurve(&another, request, &curve).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

TEST_F(GrpcTest, RendersStillWithErrorAndLimits) {
  v1::StillRequest request;
  request.set_volume_id(volume);
  request.set_preset("bone");
  request.set_width(64);
  request.set_height(48);
  request.set_samples(8);
  grpc::ClientContext context;
  v1::StillReply reply;
  const grpc::Status status = stub->RenderStill(&context, request, &reply);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(reply.jpeg().substr(0, 2), "\xff\xd8");
  EXPECT_GT(reply.error(), 0);

  // Renders a scene to a target error, with low priority.
  volume::Header header;
  header.size = {24, 24, 24};
  header.spacing = {4, 4, 4};
  header.modality = volume::Modality::kCt;
  *request.mutable_scene() = presets_for(header, whole_box(header), true).front().scene();
  request.set_samples(4096);
  request.set_error(0.2);
  request.set_background(true);
  grpc::ClientContext good_enough;
  ASSERT_TRUE(stub->RenderStill(&good_enough, request, &reply).ok());
  EXPECT_GT(reply.error(), 0);
  EXPECT_LE(reply.error(), 0.2);
  request.set_error(-1);
  grpc::ClientContext no_error;
  EXPECT_EQ(stub->RenderStill(&no_error, request, &reply).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  request.set_error(0);

  request.set_preset("none such");
  grpc::ClientContext again;
  EXPECT_EQ(stub->RenderStill(&again, request, &reply).error_code(), grpc::StatusCode::NOT_FOUND);
  request.set_width(100000);
  grpc::ClientContext third;
  EXPECT_EQ(stub->RenderStill(&third, request, &reply).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(GrpcTest, LimitsTheSamplesOfStills) {
  RenderWorker::Options options;
  options.volume_dir = store.path;
  options.still_samples = 2;
  RenderWorker thrifty(options, std::move(*make_engine(EngineChoice::kCpu, 2)), metrics, clock);
  v1::StillRequest request;
  request.set_volume_id(volume);
  request.set_preset("bone");
  request.set_width(64);
  request.set_height(64);
  const auto picture = [&](StillService& stills, std::uint32_t samples) {
    request.set_samples(samples);
    std::promise<std::string> done;
    stills.render(request, std::make_shared<const std::atomic<bool>>(false),
                  [&](Result<v1::StillReply> reply) {
                    done.set_value(reply ? reply->jpeg() : reply.error().message);
                  });
    return done.get_future().get();
  };
  const std::string two = picture(worker->stills(), 2);
  EXPECT_EQ(picture(thrifty.stills(), 32), two);
  EXPECT_NE(picture(worker->stills(), 32), two);
  thrifty.stop();
}

TEST_F(GrpcTest, LimitsPendingStills) {
  v1::StillRequest request;
  request.set_volume_id(volume);
  request.set_preset("bone");
  request.set_width(256);
  request.set_height(256);
  request.set_samples(8);
  std::atomic<int> good{0};
  std::atomic<int> refused{0};
  std::vector<std::thread> callers;
  for (int i = 0; i < 3 * StillService::kPending; ++i) {
    callers.emplace_back([&] {
      grpc::ClientContext context;
      v1::StillReply reply;
      const auto code = stub->RenderStill(&context, request, &reply).error_code();
      if (code == grpc::StatusCode::OK) ++good;
      if (code == grpc::StatusCode::RESOURCE_EXHAUSTED) ++refused;
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_GE(good, StillService::kPending);
  EXPECT_EQ(good + refused, 3 * StillService::kPending);
  EXPECT_GT(refused, 0);
}

TEST_F(GrpcTest, DrainEndsEverythingInTime) {
  Client viewer(*stub, open());
  viewer.say(hello_message());
  ASSERT_TRUE(viewer.inbox.next_of(v1::ServerMessage::kFrame));
  v1::StillRequest request;
  request.set_volume_id(volume);
  request.set_preset("bone");
  request.set_width(512);
  request.set_height(512);
  request.set_samples(4096);
  std::thread still([&] {
    grpc::ClientContext context;
    v1::StillReply reply;
    EXPECT_EQ(stub->RenderStill(&context, request, &reply).error_code(),
              grpc::StatusCode::UNAVAILABLE);
  });
  std::this_thread::sleep_for(300ms);
  const auto start = steady_clock::now();
  server->set_not_serving();
  worker->host().refuse_new();
  worker->stop();
  server->stop(1s);
  EXPECT_LT(steady_clock::now() - start, 3s);
  EXPECT_EQ(viewer.status(), grpc::StatusCode::UNAVAILABLE);
  const auto problem = viewer.inbox.next_of(v1::ServerMessage::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->problem().code(), "unavailable");
  still.join();
}

TEST_F(GrpcTest, PortInUseIsAnError) {
  GrpcServer::Options options;
  options.port = server->port();
  const auto second = GrpcServer::start(options, worker->host(), worker->stills(), metrics);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
}

std::string with_role(wire::Role role) { return "IP:127.0.0.1,URI:" + wire::role_uri(role); }

/// A CA, and a certificate of it for the server.
struct WithAuthority {
  wire::Authority ours;
  wire::TlsFiles own = ours.issue("renderd", with_role(wire::Role::kRenderd));
};

/// A worker that requires TLS and, unless `roles` is false, roles.
struct RoleTest : WithAuthority, GrpcTest {
  explicit RoleTest(bool roles = true)
      : GrpcTest(GrpcServer::Options{.tls = {.files = own, .name = {}, .roles = roles}}) {}

  std::unique_ptr<v1::RenderWorker::Stub> stub_of(const wire::TlsFiles& files) const {
    const wire::InnerTls tls{.files = files, .name = {}};
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return v1::RenderWorker::NewStub(
        wire::open_channel("127.0.0.1:" + std::to_string(server->port()), tls,
                           wire::channel_credentials(tls), arguments));
  }

  /// Calls a method with nothing to do.
  static grpc::Status call(v1::RenderWorker::Stub& stub, const std::string& method) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + 30s);
    context.set_wait_for_ready(true);
    if (method == "RenderStill") {
      v1::StillReply reply;
      return stub.RenderStill(&context, v1::StillRequest(), &reply);
    }
    if (method == "GetErrorCurve") {
      v1::ErrorCurve reply;
      return stub.GetErrorCurve(&context, v1::ErrorCurveRequest(), &reply);
    }
    const auto end_at_once = [](auto stream) {
      stream->WritesDone();
      return stream->Finish();
    };
    return method == "Attach" ? end_at_once(stub.Attach(&context))
                              : end_at_once(stub.Assist(&context));
  }

  const std::map<std::string, std::string> role_of{{"Attach", "gateway"},
                                                   {"RenderStill", "api"},
                                                   {"GetErrorCurve", "api"},
                                                   {"Assist", "renderd"}};
};

TEST_F(RoleTest, EachMethodAcceptsOnlyCertificatesOfItsRoleAndNamesIt) {
  const auto* service = v1::StillRequest::descriptor()->file()->service(0);
  ASSERT_EQ(static_cast<int>(role_of.size()), service->method_count());
  std::map<std::string, wire::TlsFiles> callers{{"no role", ours.issue("none", "DNS:none")}};
  for (const auto role :
       {wire::Role::kApi, wire::Role::kGateway, wire::Role::kRenderd, wire::Role::kOperator}) {
    const std::string name(wire::to_string(role));
    callers.emplace(name, ours.issue("caller-" + name, with_role(role)));
  }
  for (const auto& [caller, files] : callers) {
    const auto as = stub_of(files);
    for (const auto& [method, role] : role_of) {
      ASSERT_NE(service->FindMethodByName(method), nullptr);
      const grpc::Status status = call(*as, method);
      EXPECT_EQ(status.error_code() == grpc::StatusCode::PERMISSION_DENIED, caller != role)
          << method << " by " << caller << ": " << status.error_message();
      if (caller == role) continue;
      EXPECT_NE(
          status.error_message().find(method + " requires a certificate with the role " + role),
          std::string::npos);
      EXPECT_NE(status.error_message().find("certificate has " +
                                            (caller == "no role" ? caller : "the role " + caller)),
                std::string::npos)
          << status.error_message();
    }
  }
}

TEST_F(RoleTest, ACertificateMayHaveSeveralRoles) {
  const auto both = stub_of(ours.issue("both", "URI:" + wire::role_uri(wire::Role::kApi) +
                                                   ",URI:" + wire::role_uri(wire::Role::kGateway)));
  EXPECT_NE(call(*both, "Attach").error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_NE(call(*both, "RenderStill").error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(call(*both, "Assist").error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(RoleTest, RefusesAUriThatOnlyContainsTheRole) {
  for (const char* uri :
       {"spiffe://diaphane/gateway/x", "spiffe://diaphane.example/gateway",
        "https://diaphane/gateway", "spiffe://diaphane/Gateway", "spiffe://diaphane/gateway?api"}) {
    const auto as = stub_of(ours.issue("other", std::string("URI:") + uri));
    EXPECT_EQ(call(*as, "Attach").error_code(), grpc::StatusCode::PERMISSION_DENIED) << uri;
  }
  const auto by_name = stub_of(ours.issue("by-name", "DNS:gateway,DNS:diaphane"));
  EXPECT_EQ(call(*by_name, "Attach").error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

struct WithoutRolesTest : RoleTest {
  WithoutRolesTest() : RoleTest(false) {}
};

TEST_F(WithoutRolesTest, EveryCertificateOfTheAuthorityCallsEveryMethod) {
  const auto none = stub_of(ours.issue("none", "DNS:none"));
  for (const auto& [method, role] : role_of) {
    EXPECT_NE(call(*none, method).error_code(), grpc::StatusCode::PERMISSION_DENIED) << method;
  }
}

}  // namespace
}  // namespace diaphane::render
