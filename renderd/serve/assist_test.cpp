// Several workers that render one picture, over real gRPC with real CPU engines.

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <thread>

#include "api/proto/worker.grpc.pb.h"
#include "renderd/engine/cpu/engine.h"
#include "renderd/serve/grpc_assistants.h"
#include "renderd/serve/grpc_server.h"
#include "tests/support/common/claimed_port.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

/// A worker that helps. It ends like a killed one: its connections break.
struct Helper {
  explicit Helper(const std::string& store, std::uint16_t port = 0) {
    RenderWorker::Options options;
    options.volume_dir = store;
    options.host.slots = 2;
    options.runner.rules.target_error = 0.001;
    worker = std::make_unique<RenderWorker>(options, make_cpu_engine(1), metrics, clock);
    GrpcServer::Options at;
    at.port = port;
    server = std::move(
        *GrpcServer::start(at, worker->host(), worker->stills(), metrics, &worker->assists()));
  }
  ~Helper() {
    server->stop(0ms);
    worker->stop();
  }
  std::string address() const { return "127.0.0.1:" + std::to_string(server->port()); }

  prometheus::Registry registry;
  Metrics metrics{registry};
  SystemClock clock;
  std::unique_ptr<RenderWorker> worker;
  std::unique_ptr<GrpcServer> server;
};

class Assist : public testing::Test {
 protected:
  static constexpr Canvas kCanvas{96, 80};

  void start(std::size_t helpers, CompositeOptions options, std::size_t most = 0) {
    std::vector<std::string> addresses;
    for (std::size_t i = 0; i < helpers; ++i) {
      helpers_.push_back(std::make_unique<Helper>(store_.path));
      addresses.push_back(helpers_.back()->address());
    }
    source_ = std::make_unique<GrpcAssistants>(addresses, wire::InnerTls{}, most);
    std::vector<std::unique_ptr<Engine>> devices;
    devices.push_back(make_cpu_engine(1));
    engine_ = make_composite_engine(std::move(devices), source_.get(), options);
    const auto volume = volume::read(store_.path + "/" + volume_, false);
    ASSERT_TRUE(volume);
    loaded_ = *engine_->load(*volume);
    scene_ = presets_for(loaded_->header(), whole_box(loaded_->header()), true).front().scene();
    renderer_ = *engine_->renderer(loaded_, 5, 0, kSharedMethod);
    ASSERT_TRUE(renderer_->set_scene(scene_, kCanvas));
  }
  ~Assist() override {
    renderer_.reset();
    engine_.reset();
    source_.reset();
  }
  const CompositeReport& report() const {
    return dynamic_cast<CompositeRenderer&>(*renderer_).composite();
  }
  /// Renders like the scheduler until `test` holds. Returns false after two minutes.
  bool until(const std::function<bool()>& test) {
    const auto end = steady_clock::now() + 120s;  // on a busy machine
    while (!test()) {
      if (steady_clock::now() > end) return false;
      EXPECT_TRUE(renderer_->render(2, [] { return false; }));
      (void)renderer_->progress();
    }
    return true;
  }
  /// Returns the root mean square difference of the displayed picture to that of one device.
  double off() {
    const auto one = make_cpu_engine(2);
    const auto volume = volume::read(store_.path + "/" + volume_, false);
    const auto truth = *one->renderer(*one->load(*volume), 99, 0, kSharedMethod);
    EXPECT_TRUE(truth->set_scene(scene_, kCanvas));
    EXPECT_TRUE(truth->render(100, [] { return false; }));
    PictureRgb8 a, b;
    EXPECT_TRUE(renderer_->display(a) && truth->display(b));
    double squared = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      squared += std::pow((a.pixels[i] - b.pixels[i]) / 255.0, 2);
    }
    return std::sqrt(squared / static_cast<double>(a.pixels.size()));
  }

  TestStore store_;
  std::string volume_ = store_.add_ball();
  std::vector<std::unique_ptr<Helper>> helpers_;
  std::unique_ptr<GrpcAssistants> source_;
  std::unique_ptr<Engine> engine_;
  std::shared_ptr<const DeviceVolume> loaded_;
  v1::Scene scene_;
  std::unique_ptr<FrameRenderer> renderer_;
};

TEST_F(Assist, LeavingOrJoiningWorkerCostsOrAddsOnlyItsShare) {
  for (const Division division : {Division::kAverage, Division::kTiles}) {
    start(2, {.division = division});
    const auto parts = [&](std::uint64_t more) {
      return [this, requested = report().parts + more] { return report().parts >= requested; };
    };
    ASSERT_TRUE(until([&] { return report().assistants == 2; })) << "they join in mid-picture";
    ASSERT_TRUE(until(parts(4)));

    const std::uint16_t port = helpers_[0]->server->port();
    helpers_[0].reset();
    ASSERT_TRUE(until([&] { return report().assistants == 1; }));
    const auto before = renderer_->progress().samples;
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= before + 20; }))
        << "the picture continues";
    helpers_[0] = std::make_unique<Helper>(store_.path, port);
    ASSERT_TRUE(until([&] { return report().assistants == 2; })) << "it is back";
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= 80; }));
    EXPECT_LT(off(), 0.04);
    EXPECT_EQ(report().dropped_parts, 0u);

    // While the camera moves, only parts of the newest picture count.
    for (int step = 0; step < 10; ++step) {
      scene_ = turned(scene_, 25);
      ASSERT_TRUE(renderer_->set_scene(scene_, kCanvas));
      ASSERT_TRUE(renderer_->render(1, [] { return false; }));
    }
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= 80; }));
    EXPECT_LT(off(), 0.04) << "a ghost";
    renderer_.reset();
    engine_.reset();
    source_.reset();
    helpers_.clear();
  }
}

TEST_F(Assist, AssistantStopsWhenTheImageIsNotWatched) {
  start(1, {.division = Division::kAverage});
  ASSERT_TRUE(until([&] { return report().parts >= 3; }));
  // Without a viewer, the helper renders at most what it has delivered.
  const auto busy = [&] { return helpers_[0]->worker->homes().busy_seconds(); };
  bool rests = false;
  for (int i = 0; i < 20 && !rests; ++i) {
    const double before = busy();
    std::this_thread::sleep_for(300ms);
    rests = busy() == before;
  }
  EXPECT_TRUE(rests);
  const auto parts = report().parts;
  ASSERT_TRUE(until([&] { return report().parts > parts + 1; })) << "and continues";
  // When the session ends, it frees its place there.
  EXPECT_EQ(helpers_[0]->worker->assists().used(), 1u);
  renderer_.reset();
  for (int i = 0; i < 500 && helpers_[0]->worker->assists().used() > 0; ++i) {
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_EQ(helpers_[0]->worker->assists().used(), 0u);
}

TEST_F(Assist, BorrowedHelperJoinsDuringRenderingAndLeavesWhenReturned) {
  for (const Division division : {Division::kAverage, Division::kTiles}) {
    start(0, {.division = division}, 1);
    Helper first(store_.path), second(store_.path);
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= 8; }));
    EXPECT_EQ(report().assistants, 0u);

    source_->borrow({{first.address()}});
    ASSERT_TRUE(until([&] { return report().assistants == 1 && report().parts >= 2; }));
    EXPECT_GT(source_->helped_seconds(), 0);
    EXPECT_GT(first.worker->assists().lent_seconds(), 0);

    // It is released although nothing is rendered meanwhile.
    source_->borrow({});
    EXPECT_TRUE(eventually([&] { return first.worker->assists().used() == 0; }));
    const auto before = renderer_->progress().samples;
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= before + 20; }))
        << "the picture continues";
    EXPECT_EQ(report().assistants, 0u);

    source_->borrow({{second.address()}});
    const auto parts = report().parts;
    ASSERT_TRUE(until([&] { return report().parts >= parts + 2; })) << "another in its place";
    EXPECT_EQ(first.worker->assists().used(), 0u);
    ASSERT_TRUE(until([&] { return renderer_->progress().samples >= 80; }));
    EXPECT_LT(off(), 0.04);
    renderer_.reset();
    engine_.reset();
    source_.reset();
  }
}

TEST_F(Assist, ReportsAndStopsAskingUnavailableHelpers) {
  start(0, {.division = Division::kAverage}, 2);
  TestStore empty;
  Helper without(empty.path), with(store_.path);
  const ClaimedPort claimed = ClaimedPort::take().value();
  const std::string nobody = "127.0.0.1:" + std::to_string(claimed.number());
  for (const std::string& refuses : {without.address(), nobody}) {
    source_->borrow({{refuses}, {with.address()}});
    EXPECT_TRUE(until([&] { return source_->refusing() == std::vector{refuses}; })) << refuses;
    ASSERT_TRUE(until([&] { return report().assistants == 1; })) << "the other helps";
    EXPECT_TRUE(eventually([&] { return without.worker->assists().used() == 0; }));
    source_->borrow({});
    EXPECT_TRUE(source_->refusing().empty());
  }
}

TEST_F(Assist, HelperAssistsAsManyImagesAsFit) {
  start(0, {.division = Division::kAverage}, 1);
  Helper helper(store_.path);  // for at most two pictures
  source_->borrow({{helper.address()}});
  std::vector<std::unique_ptr<FrameRenderer>> more;
  for (int i = 0; i < 2; ++i) {
    more.push_back(*engine_->renderer(loaded_, 6, 0, kSharedMethod));
    ASSERT_TRUE(more.back()->set_scene(scene_, kCanvas));
  }
  const auto step = [&] {
    for (const auto& one : more) {
      EXPECT_TRUE(one->render(2, [] { return false; }));
      (void)one->progress();
    }
    EXPECT_TRUE(source_->refusing().empty());
  };
  ASSERT_TRUE(until([&] {
    step();
    return helper.worker->assists().used() == 2;
  }));
  // The third retries every second.
  const auto begun = steady_clock::now();
  ASSERT_TRUE(until([&] {
    step();
    return steady_clock::now() - begun > 2500ms;
  }));
  EXPECT_EQ(helper.worker->assists().used(), 2u);
}

TEST_F(Assist, SpareTimeGivesWayToOthersAndToMemory) {
  start(0, {.division = Division::kAverage}, 2);
  Helper helper(store_.path);  // for at most two pictures
  source_->borrow({{helper.address(), true}});
  AssistHost& assists = helper.worker->assists();
  ASSERT_TRUE(until([&] { return report().parts >= 2; }));
  EXPECT_GT(helper.worker->homes().times().busy, 0);
  EXPECT_EQ(helper.worker->homes().busy_seconds(), 0) << "spare time does not count as load";
  EXPECT_EQ(assists.lent_seconds(), 0);
  EXPECT_EQ(assists.used(), 1u);
  EXPECT_TRUE(assists.end_spare());
  EXPECT_FALSE(assists.end_spare());
  ASSERT_TRUE(until([&] { return assists.used() == 1; })) << "it returns";

  // The same worker is needed now.
  source_->borrow({{helper.address()}});
  ASSERT_TRUE(until([&] { return assists.lent_seconds() > 0.01; }));
  EXPECT_GT(helper.worker->homes().busy_seconds(), 0);
  EXPECT_FALSE(assists.end_spare());
  EXPECT_EQ(source_->borrowed(), std::vector{helper.address()});
}

TEST_F(Assist, NeededPicturesEndThoseWithSpareTime) {
  start(0, {.division = Division::kAverage}, 1);
  Helper helper(store_.path);  // for at most two pictures
  GrpcAssistants needed({}, {}, 1);
  std::vector<std::unique_ptr<Engine>> devices;
  devices.push_back(make_cpu_engine(1));
  const auto other = make_composite_engine(std::move(devices), &needed, {});
  std::vector<std::unique_ptr<FrameRenderer>> more;
  for (Engine* engine :
       {engine_.get(), static_cast<Engine*>(other.get()), static_cast<Engine*>(other.get())}) {
    more.push_back(*engine->renderer(loaded_, 6, 0, kSharedMethod));
    ASSERT_TRUE(more.back()->set_scene(scene_, kCanvas));
  }
  const auto step = [&] {
    for (const auto& one : more) {
      EXPECT_TRUE(one->render(2, [] { return false; }));
      (void)one->progress();
    }
  };
  AssistHost& assists = helper.worker->assists();
  source_->borrow({{helper.address(), true}});
  ASSERT_TRUE(until([&] {
    step();
    return assists.used() == 2;
  }));
  needed.borrow({{helper.address()}});
  const auto helped = [&](const auto& renderer) {
    return dynamic_cast<CompositeRenderer&>(*renderer).composite().parts > 0;
  };
  EXPECT_TRUE(until([&] {
    step();
    return helped(more[1]) && helped(more[2]);
  }));
  EXPECT_TRUE(needed.refusing().empty());
  more.clear();
}

/// Messages that any client may send, and how the call ends.
TEST_F(Assist, InvalidMessageEndsOnlyItsCall) {
  start(1, {.division = Division::kAverage});
  const auto stub = v1::RenderWorker::NewStub(
      grpc::CreateChannel(helpers_[0]->address(), grpc::InsecureChannelCredentials()));
  const auto status_of = [&](const std::vector<v1::AssistRequest>& requests) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + 10s);
    const auto stream = stub->Assist(&context);
    for (const auto& request : requests) stream->Write(request);
    v1::AssistReply reply;
    while (stream->Read(&reply)) {
    }
    return stream->Finish().error_code();
  };
  v1::AssistRequest open, task, wrong;
  open.mutable_open()->set_volume_id(volume_);
  v1::AssistTask& order = *task.mutable_task();
  *order.mutable_scene() = scene_;
  order.set_width(64);
  order.set_height(64);
  order.set_last_row(64);
  order.set_parts(1);
  EXPECT_EQ(status_of({task}), grpc::StatusCode::INVALID_ARGUMENT) << "before open";
  EXPECT_EQ(status_of({open, open}), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status_of({wrong}), grpc::StatusCode::INVALID_ARGUMENT);
  wrong.mutable_open()->set_volume_id("../../etc");
  EXPECT_EQ(status_of({wrong}), grpc::StatusCode::INVALID_ARGUMENT);
  wrong.mutable_open()->set_volume_id(new_id());
  EXPECT_EQ(status_of({wrong}), grpc::StatusCode::NOT_FOUND);
  for (const auto& spoil : std::vector<std::function<void(v1::AssistTask&)>>{
           [](v1::AssistTask& t) { t.set_width(0); },
           [](v1::AssistTask& t) { t.set_height(100'000); },
           [](v1::AssistTask& t) { t.set_first_row(8); },
           [](v1::AssistTask& t) { t.set_last_row(0); }, [](v1::AssistTask& t) { t.set_parts(0); },
           [](v1::AssistTask& t) { t.set_part(1); },
           [](v1::AssistTask& t) { t.set_sequence(~0ull); },
           [](v1::AssistTask& t) { t.mutable_scene()->Clear(); }}) {
    v1::AssistRequest bad = task;
    spoil(*bad.mutable_task());
    EXPECT_EQ(status_of({open, bad}), grpc::StatusCode::INVALID_ARGUMENT);
  }
  EXPECT_TRUE(until([&] { return report().parts >= 3; })) << "the remaining image is assisted";
}

}  // namespace
}  // namespace diaphane::render
