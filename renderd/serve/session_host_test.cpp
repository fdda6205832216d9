#include "renderd/serve/session_host.h"

#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <thread>

#include "renderd/scene/texture_store.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_textures.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;
using Kind = v1::ServerMessage;

// A viewer that acknowledges messages on request.
struct Viewer : TestViewer {
  // Acknowledges frames until one passes.
  std::optional<v1::Frame> follow(const std::function<bool(const v1::Frame&)>& until) {
    for (;;) {
      const auto message = link->inbox.next_of(Kind::kFrame);
      if (!message) return std::nullopt;
      say(ack_message(message->frame().seq()));
      if (until(message->frame())) return message->frame();
    }
  }
  // Returns the next Problem, and acknowledges frames before it.
  std::optional<v1::Problem> refusal() {
    for (;;) {
      const auto message = link->inbox.next([](const auto&) { return true; });
      if (!message) return std::nullopt;
      if (message->has_frame()) say(ack_message(message->frame().seq()));
      if (message->has_problem()) return message->problem();
    }
  }
};

struct HostTest : testing::Test {
  HostTest() {
    device->seconds_per_megapixel = 0.25;  // 1 ms for a sample of 64 x 64
    options.volume_dir = store.path;
    options.host.slots = 3;
    options.runner.rules.target_error = 0.05;  // of the fake renderer: 100 samples
    restart();
  }
  void restart() {
    worker.reset();
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
  }

  Viewer attach(const std::string& session, std::uint64_t placement = 1, bool greet = true) {
    Viewer viewer;
    v1::Open open;
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(placement);
    auto opened = worker->host().open(open, viewer.link);
    EXPECT_TRUE(opened) << opened.error().message;
    if (opened) viewer.attachment = std::move(*opened);
    if (greet) viewer.say(hello_message());
    return viewer;
  }
  Viewer join(const std::string& session) {
    Viewer viewer;
    v1::Open open;
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(1);
    open.set_participant(new_id());
    viewer.attachment.emplace(*worker->host().open(open, viewer.link));
    viewer.say(hello_message());
    return viewer;
  }
  /// Returns false if no place for a visitor is free.
  bool visit(const std::string& session, Viewer& viewer) {
    v1::Open open;
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(1);
    open.set_visitor(true);
    auto opened = worker->host().open(open, viewer.link);
    if (!opened) return false;
    viewer.attachment = std::move(*opened);
    viewer.say(hello_message());
    return true;
  }
  Result<Attachment> try_open(const std::string& session, std::uint64_t placement = 1) {
    v1::Open open;
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(placement);
    return worker->host().open(open, std::make_shared<Link>());
  }

  TestStore store;
  std::string volume = store.add_ball();
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SharedManualClock manual;
  SystemClock system;
  const Clock& clock = system;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
};

/// Render time is charged to the user who opened the session, including the work of other workers
/// and guests' free cameras. Visitors' sessions and stills are not charged.
TEST_F(HostTest, ChargesTheOwnerForImagesButNobodyForStills) {
  const std::string user = new_id();
  device->helped_seconds = 3;
  Viewer one;
  v1::Open open;
  open.set_session_id(new_id());
  open.set_volume_id(volume);
  open.set_placement(1);
  open.set_user_id(user);
  one.attachment.emplace(*worker->host().open(open, one.link));
  one.say(hello_message());
  ASSERT_TRUE(one.follow([](const v1::Frame& frame) { return frame.error() <= 0.05; }));
  const auto charged = worker->host().gpu_time().take_milliseconds();
  ASSERT_EQ(charged.size(), 1U);
  const std::uint64_t ms = charged.at(user);
  // 100 samples of a millisecond in at most as many batches, each with three helpers.
  EXPECT_GE(ms, 3000U + 80);
  EXPECT_LE(ms, 300'000U + 5000);

  Viewer nobody = attach(new_id());
  ASSERT_TRUE(nobody.follow([](const v1::Frame& frame) { return frame.error() <= 0.05; }));
  v1::StillRequest still;
  still.set_volume_id(volume);
  still.set_preset("bone");
  still.set_width(64);
  still.set_height(64);
  still.set_samples(8);
  std::promise<bool> done;
  worker->stills().render(still, std::make_shared<const std::atomic<bool>>(false),
                          [&](Result<v1::StillReply> reply) { done.set_value(reply.has_value()); });
  EXPECT_TRUE(done.get_future().get());
  EXPECT_TRUE(worker->host().gpu_time().take_milliseconds().empty());
}

TEST_F(HostTest, SendsConfigurationAndConvergingFrames) {
  Viewer one = attach(new_id());
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  EXPECT_EQ(config->config().engine(), "fake");
  EXPECT_EQ(config->config().volume().size(0), 24U);
  EXPECT_EQ(config->config().presets_size(), 5);
  EXPECT_TRUE(config->config().has_scene());
  double error = std::numeric_limits<double>::infinity();
  std::uint64_t seq = 0;
  const auto last = one.follow([&](const v1::Frame& frame) {
    EXPECT_EQ(frame.seq(), ++seq);
    EXPECT_LE(frame.error(),
              frame.iteration() == 1 ? std::numeric_limits<double>::infinity() : error);
    error = frame.error();
    return frame.error() <= 0.05;
  });
  ASSERT_TRUE(last);
  const auto state = one.link->inbox.next_of(Kind::kState);
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->state().converged());
  EXPECT_EQ(state->state().epoch(), last->epoch());
}

TEST_F(HostTest, SendsTwoFramesWithoutAcknowledgement) {
  Viewer one = attach(new_id());
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  EXPECT_FALSE(one.link->inbox.next_of(Kind::kFrame, 300ms));
  one.say(ack_message(2));
  const auto third = one.link->inbox.next_of(Kind::kFrame);
  ASSERT_TRUE(third);
  EXPECT_GT(third->frame().iteration(), 2U) << "the latest frame, not the oldest";
}

TEST_F(HostTest, StalledViewerDoesNotSlowOthers) {
  Viewer stuck = attach(new_id());
  ASSERT_TRUE(stuck.link->inbox.next_of(Kind::kFrame));
  Viewer one = attach(new_id());
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t input = 1; input <= 20; ++input) {
    one.say(scene_message(input, turned(config->config().scene(), double(input))));
    stuck.say(scene_message(input, turned(config->config().scene(), double(input))));
    ASSERT_TRUE(one.follow([&](const v1::Frame& frame) { return frame.input_seq() >= input; }));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);
  EXPECT_LE(stuck.link->inbox.count(Kind::kFrame), 2U);
}

TEST_F(HostTest, LoadsVolumeOnceForAllSessions) {
  Viewer one = attach(new_id());
  Viewer two = attach(new_id());
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  ASSERT_TRUE(two.link->inbox.next_of(Kind::kFrame));
  EXPECT_EQ(device->volumes, 1);
  EXPECT_EQ(worker->volumes().loaded(), std::vector<std::string>{volume});
}

TEST_F(HostTest, RefusesNonFiniteSceneAndKeepsTheImage) {
  Viewer one = attach(new_id());
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  const auto shown = one.follow([](const v1::Frame&) { return true; });
  const int scenes = device->scenes;
  v1::Scene wrong = config->config().scene();
  wrong.mutable_transfer_function()->set_extinction_per_mm(
      std::numeric_limits<double>::quiet_NaN());
  one.say(scene_message(9, wrong));
  const auto problem = one.link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_FALSE(problem->problem().fatal());
  EXPECT_EQ(problem->problem().input_seq(), 9U);
  EXPECT_EQ(problem->problem().field(), "transferFunction.extinctionPerMm");
  const auto after = one.follow([](const v1::Frame& frame) { return frame.iteration() > 16; });
  ASSERT_TRUE(after);
  EXPECT_EQ(after->input_seq(), shown->input_seq());
  EXPECT_LE(device->scenes, scenes + 1) << "at most the step from moving to rest";
}

TEST_F(HostTest, MalformedMessageEndsOnlyTheConnection) {
  const std::string id = new_id();
  Viewer one = attach(id);
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  one.attachment->receive("\xff\xff\xff garbage");
  const auto problem = one.link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_TRUE(problem->problem().fatal());
  EXPECT_EQ(one.link->inbox.ended()->code, ErrorCode::kInvalid);
  EXPECT_EQ(worker->host().used(), 1U);
}

TEST_F(HostTest, SecondConnectionTakesOverFilmAndScene) {
  const std::string id = new_id();
  Viewer one = attach(id);
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  one.say(scene_message(5, turned(config->config().scene(), 3)));
  const auto converged = one.follow(
      [](const v1::Frame& frame) { return frame.input_seq() == 5 && frame.error() <= 0.05; });
  ASSERT_TRUE(converged);
  const std::uint64_t samples = device->samples;

  Viewer two = attach(id, 2);
  EXPECT_EQ(one.link->inbox.ended()->code, ErrorCode::kConflict);
  const auto again = two.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->config().input_seq(), 5U);
  EXPECT_EQ(again->config().scene().camera().eye().x(),
            config->config().scene().camera().eye().x() + 3);
  const auto frame = two.link->inbox.next_of(Kind::kFrame);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame().seq(), 1U);
  EXPECT_EQ(frame->frame().iteration(), converged->iteration());
  EXPECT_EQ(device->samples, samples) << "nothing had to be rendered again";
  // The old connection's last messages no longer count.
  one.say(scene_message(6, config->config().scene()));
  one.attachment->closed();
  for (const SavedSession& saved : worker->host().take_unsaved()) EXPECT_EQ(saved.input_seq, 5U);
  two.say(ack_message(1));
  EXPECT_EQ(worker->host().used(), 1U);
  EXPECT_FALSE(two.link->inbox.ended(50ms));
}

TEST_F(HostTest, RefusesOlderPlacement) {
  const std::string id = new_id();
  Viewer one = attach(id, 5);
  EXPECT_EQ(try_open(id, 4).error().code, ErrorCode::kConflict);
  EXPECT_FALSE(one.link->inbox.ended(50ms));
  EXPECT_TRUE(try_open(id, 5));
}

TEST_F(HostTest, RefusesSessionsOverTheSlotsUnlessOneIsAbandoned) {
  Viewer one = attach(new_id());
  Viewer two = attach(new_id());
  Viewer three = attach(new_id());
  const auto refused = try_open(new_id());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooMany);
  EXPECT_FALSE(three.link->inbox.ended(20ms));
  two.attachment->closed();
  EXPECT_TRUE(try_open(new_id()));
  EXPECT_EQ(worker->host().used(), 3U);
}

TEST_F(HostTest, RefusesInvalidVolumeIds) {
  v1::Open open;
  open.set_session_id(new_id());
  for (const char* id : {"", "..", "../../etc", "A", "/etc/passwd"}) {
    open.set_volume_id(id);
    EXPECT_EQ(worker->host().open(open, std::make_shared<Link>()).error().code,
              ErrorCode::kInvalid);
  }
}

TEST_F(HostTest, MissingVolumeEndsTheSessionWithAReason) {
  volume = new_id();
  Viewer one = attach(new_id());
  const auto problem = one.link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_TRUE(problem->problem().fatal());
  EXPECT_EQ(problem->problem().code(), "not_found");
  EXPECT_EQ(one.link->inbox.ended()->code, ErrorCode::kNotFound);
  EXPECT_TRUE(eventually([&] { return worker->host().used() == 0; }));
}

TEST_F(HostTest, HandsOverTheSceneOncePerChange) {
  const std::string id = new_id();
  Viewer one = attach(id, 7);
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  worker->host().take_unsaved();
  EXPECT_TRUE(worker->host().take_unsaved().empty());
  one.say(scene_message(3, turned(config->config().scene(), 1)));
  auto saved = worker->host().take_unsaved();
  ASSERT_EQ(saved.size(), 1U);
  EXPECT_EQ(saved[0].id, id);
  EXPECT_EQ(saved[0].placement, 7U);
  EXPECT_EQ(saved[0].input_seq, 3U);
  EXPECT_EQ(saved[0].viewport, (Canvas{64, 64}));
  v1::Scene scene;
  ASSERT_TRUE(scene.ParseFromString(saved[0].scene));
  EXPECT_TRUE(worker->host().take_unsaved().empty());
  worker->host().mark_unsaved(id);
  EXPECT_EQ(worker->host().take_unsaved().size(), 1U);
}

TEST_F(HostTest, MovedSessionContinuesWithItsScene) {
  Viewer first = attach(new_id());
  const auto config = first.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  v1::Open open;
  open.set_session_id(new_id());
  open.set_volume_id(volume);
  open.set_placement(3);
  *open.mutable_scene() = turned(config->config().scene(), 42);
  open.set_input_seq(17);
  Viewer two;
  two.attachment.emplace(*worker->host().open(open, two.link));
  two.say(hello_message());
  const auto again = two.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->config().input_seq(), 17U);
  EXPECT_EQ(again->config().scene().camera().eye().x(), open.scene().camera().eye().x());
  const auto frame = two.follow([](const v1::Frame&) { return true; });
  EXPECT_EQ(frame->input_seq(), 17U);
  EXPECT_GT(frame->epoch(), std::uint64_t{3} << 24) << "above every epoch of the placement before";
}

TEST_F(HostTest, RendersAndEncodesOnceForAllViewers) {
  const std::string id = new_id();
  Viewer owner = attach(id);
  Viewer ann = join(id);
  Viewer bob = join(id);
  const auto config = ann.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  EXPECT_TRUE(config->config().follower());
  owner.say(
      scene_message(4, turned(owner.link->inbox.next_of(Kind::kConfig)->config().scene(), 9)));
  for (Viewer* one : {&owner, &ann, &bob}) {
    ASSERT_TRUE(one->follow([](const v1::Frame& frame) { return frame.input_seq() == 4; }));
  }
  EXPECT_EQ(worker->host().used(), 1U);
  EXPECT_EQ(device->volumes, 1);
  // The follower receives the scene before its picture, and may not change it.
  bool received_look = false;
  for (const v1::ServerMessage& message : ann.link->inbox.all()) {
    if (message.has_look() && message.look().input_seq() == 4) received_look = true;
    if (message.has_frame() && message.frame().input_seq() == 4) {
      EXPECT_TRUE(received_look);
    }
  }
  ann.say(scene_message(1, config->config().scene()));
  const auto refused = ann.link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->problem().code(), "forbidden");
  bob.attachment->closed();
  EXPECT_FALSE(owner.link->inbox.ended(20ms));
}

TEST_F(HostTest, FreeCameraFollowsSettingsButNotTheCamera) {
  const std::string id = new_id();
  Viewer owner = attach(id);
  Viewer ann = join(id);
  const auto config = ann.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  v1::ClientMessage own;
  own.mutable_free_camera()->set_on(true);
  ann.say(own);
  const auto again = ann.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->config().follower());
  EXPECT_EQ(worker->host().used(), 2U) << "it costs a slot, and is counted";
  const v1::Scene mine = turned(again->config().scene(), 77);
  // Each input's frame has its own number, so the last is at least 6.
  for (std::uint64_t input = 5; input <= 10; ++input) {
    ann.say(scene_message(input, turned(mine, static_cast<double>(input))));
    ASSERT_TRUE(ann.follow([&](const v1::Frame& frame) { return frame.input_seq() == input; }));
  }
  const int before = device->scenes;
  v1::Scene settings = turned(config->config().scene(), 3);
  settings.mutable_transfer_function()->set_extinction_per_mm(0.123);
  owner.say(scene_message(2, settings));
  ASSERT_TRUE(owner.follow([](const v1::Frame& frame) { return frame.input_seq() == 2; }));
  EXPECT_TRUE(eventually([&] { return device->scenes >= before + 2; }))
      << "both are rendered again";
  // Returns to the presenter's view, and the slot is free again.
  own.mutable_free_camera()->set_on(false);
  ann.say(own);
  const auto back = ann.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->config().follower());
  EXPECT_EQ(back->config().scene().camera().eye().x(), settings.camera().eye().x());
  const auto frame = ann.link->inbox.next_of(Kind::kFrame);
  ASSERT_TRUE(frame);
  EXPECT_LT(frame->frame().seq(), 6U)
      << "started again; of two that no viewer received, the first is left out";
  EXPECT_EQ(worker->host().used(), 1U);
  // It also ends with its viewer.
  own.mutable_free_camera()->set_on(true);
  ann.say(own);
  ASSERT_TRUE(ann.link->inbox.next_of(Kind::kConfig));
  ann.attachment->closed();
  EXPECT_EQ(worker->host().used(), 1U);
  EXPECT_FALSE(owner.link->inbox.ended(20ms));
}

TEST_F(HostTest, LimitsGuestCamerasToAQuarterOfTheSlotsAndDisplacesThem) {
  options.host.slots = 4;
  restart();
  const std::string id = new_id();
  Viewer owner = attach(id);
  std::vector<Viewer> guests;
  v1::ClientMessage own;
  own.mutable_free_camera()->set_on(true);
  for (int i = 0; i < 2; ++i) {
    guests.push_back(join(id));
    ASSERT_TRUE(guests.back().link->inbox.next_of(Kind::kConfig));
    guests.back().say(own);
  }
  const auto first = guests[0].link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->config().follower());
  const auto refused = guests[1].link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->problem().code(), "too_many");
  EXPECT_EQ(worker->host().used(), 2U);

  Viewer second = attach(new_id()), third = attach(new_id());
  EXPECT_EQ(guests[0].link->inbox.count(Kind::kProblem), 0U) << "there was room";
  Viewer fourth = attach(new_id());
  const auto why = guests[0].refusal();
  ASSERT_TRUE(why);
  EXPECT_EQ(why->field(), "own_camera_taken");
  EXPECT_FALSE(why->fatal());
  EXPECT_TRUE(guests[0].follow([](const v1::Frame&) { return true; }))
      << "it sees the presenter's picture again";
  EXPECT_EQ(worker->host().used(), 4U);
  EXPECT_EQ(try_open(new_id()).error().code, ErrorCode::kTooMany)
      << "account holders do not displace each other";
}

TEST_F(HostTest, VisitorWhoLeftDoesNotKeepAGuestFromACamera) {
  options.host.slots = 4;
  restart();
  const std::string id = new_id();
  Viewer owner = attach(id), visitor;
  ASSERT_TRUE(visit(new_id(), visitor));
  Viewer guest = join(id);
  ASSERT_TRUE(guest.link->inbox.next_of(Kind::kConfig));
  v1::ClientMessage own;
  own.mutable_free_camera()->set_on(true);
  guest.say(own);
  ASSERT_TRUE(guest.refusal()) << "the only place for visitors is taken";
  visitor.attachment->closed();
  EXPECT_EQ(worker->host().used(), 2U) << "the visitor may return";
  guest.say(own);
  const auto config = guest.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  EXPECT_FALSE(config->config().follower());
}

TEST_F(HostTest, AccountHolderDisplacesVisitorWithAReason) {
  options.host.slots = 4;
  restart();
  Viewer visitor, another;
  ASSERT_TRUE(visit(new_id(), visitor));
  EXPECT_FALSE(visit(new_id(), another)) << "one of four slots is the visitors'";
  ASSERT_EQ(worker->host().live().size(), 1U);
  EXPECT_TRUE(worker->host().live().front().visitor);
  std::vector<Viewer> holders;
  for (int i = 0; i < 4; ++i) holders.push_back(attach(new_id()));
  const auto why = visitor.link->inbox.ended();
  ASSERT_TRUE(why);
  EXPECT_TRUE(is_displaced(*why));
  EXPECT_FALSE(visit(new_id(), another)) << "a visitor displaces nobody";
  for (Viewer& holder : holders) EXPECT_FALSE(holder.link->inbox.ended(1ms));
}

/// Returns the field of the picture that `textured` adds.
std::string texture_field(const v1::Scene& before) {
  return "lights[" + std::to_string(before.lights_size()) + "].environment.texture";
}

/// Returns the scene with an additional light that has a picture.
v1::Scene textured(v1::Scene scene, unsigned number, std::uint32_t side) {
  v1::Light& light = *scene.add_lights();
  auto& environment = *light.mutable_environment();
  environment.mutable_radiance()->set_r(1);
  environment.mutable_texture()->set_picture(
      test::png(side, side, [number](std::uint32_t, std::uint32_t) {
        return test::Rgb8{static_cast<std::uint8_t>(number), 1, 2};
      }));
  return scene;
}

TEST_F(HostTest, BoundsTextureMemoryOfAllSessionsAndKeepsTheImageOnRefusal) {
  if (test::png(1, 1, [](auto, auto) { return test::Rgb8{}; }).empty()) GTEST_SKIP();
  constexpr std::size_t kBytes = std::size_t{256} * 256 * 16;
  limit_texture_memory(2 * kBytes, 2 * kBytes);
  std::vector<Viewer> viewers;
  std::string field;
  for (unsigned i = 0; i < 2; ++i) {
    viewers.push_back(attach(new_id()));
    const auto config = viewers.back().link->inbox.next_of(Kind::kConfig);
    ASSERT_TRUE(config);
    field = texture_field(config->config().scene());
    viewers.back().say(scene_message(2, textured(config->config().scene(), i, 256)));
    if (i == 0) {
      ASSERT_TRUE(viewers[0].follow([](const v1::Frame& frame) { return frame.input_seq() == 2; }));
      EXPECT_GE(texture_memory(), kBytes);
    }
  }
  const auto refused = viewers[1].refusal();
  ASSERT_TRUE(refused) << "the second needs a little more than there is left";
  EXPECT_EQ(refused->field(), field);
  EXPECT_FALSE(refused->fatal());
  EXPECT_EQ(refused->input_seq(), 2U);
  ASSERT_TRUE(viewers[1].follow([](const v1::Frame&) { return true; })) << "the picture stays";
  viewers.clear();
  restart();
  EXPECT_EQ(texture_memory(), 0U);
  limit_texture_memory(kTextureMemory, kOwnersTextureMemory);
}

TEST_F(HostTest, LimitsTheTexturePixelsOfVisitors) {
  if (test::png(1, 1, [](auto, auto) { return test::Rgb8{}; }).empty()) GTEST_SKIP();
  options.host.slots = 4;
  restart();
  Viewer visitor;
  v1::Open open;
  open.set_session_id(new_id());
  open.set_volume_id(volume);
  open.set_placement(1);
  open.set_visitor(true);
  visitor.attachment.emplace(*worker->host().open(open, visitor.link));
  visitor.say(hello_message());
  const auto config = visitor.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  visitor.say(scene_message(2, textured(config->config().scene(), 1, 1025)));
  const auto refused = visitor.refusal();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code(), "invalid");
  EXPECT_EQ(refused->field(), texture_field(config->config().scene()));
  visitor.say(scene_message(3, textured(config->config().scene(), 1, 1024)));
  ASSERT_TRUE(visitor.follow([](const v1::Frame& frame) { return frame.input_seq() == 3; }));
}

TEST_F(HostTest, DrainDisconnectsEveryViewerAsUnavailable) {
  Viewer one = attach(new_id());
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  worker->host().refuse_new();
  EXPECT_EQ(try_open(new_id()).error().code, ErrorCode::kUnavailable);
  worker->host().end_all();
  const auto problem = one.link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_TRUE(problem->problem().fatal());
  EXPECT_EQ(problem->problem().code(), "unavailable");
  EXPECT_EQ(one.link->inbox.ended()->code, ErrorCode::kUnavailable);
}

TEST_F(HostTest, CoalescesThousandsOfScenesPerSecond) {
  Viewer one = attach(new_id());
  Viewer other = attach(new_id());
  const auto config = one.link->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  ASSERT_TRUE(other.link->inbox.next_of(Kind::kFrame));
  const int before = device->scenes;
  for (std::uint64_t input = 1; input <= 10000; ++input) {
    one.say(scene_message(input, turned(config->config().scene(), double(input))));
  }
  ASSERT_TRUE(one.follow([](const v1::Frame& frame) { return frame.input_seq() == 10000; }));
  EXPECT_LT(device->scenes - before, 5000);
  other.say(ack_message(1));
  EXPECT_TRUE(other.link->inbox.next_of(Kind::kFrame));
}

TEST_F(HostTest, EndsConnectionWithoutGreeting) {
  worker.reset();
  worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                          manual);
  Viewer silent = attach(new_id(), 1, false);
  Viewer one = attach(new_id());
  manual.advance(9s);
  worker->host().tick();
  EXPECT_FALSE(silent.link->inbox.ended(20ms));
  manual.advance(2s);
  worker->host().tick();
  EXPECT_EQ(silent.link->inbox.ended()->code, ErrorCode::kInvalid);
  EXPECT_FALSE(one.link->inbox.ended(20ms));
}

TEST_F(HostTest, KeepsAbandonedSessionForThirtySeconds) {
  worker.reset();
  worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                          manual);
  const std::string id = new_id();
  Viewer one = attach(id);
  ASSERT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  one.attachment->closed();
  manual.advance(29s);
  worker->host().tick();
  EXPECT_EQ(worker->host().used(), 1U);
  Viewer back = attach(id);
  manual.advance(5s);
  worker->host().tick();
  EXPECT_EQ(worker->host().used(), 1U) << "a viewer has reconnected";
  back.attachment->closed();
  manual.advance(31s);
  worker->host().tick();
  EXPECT_EQ(worker->host().used(), 0U);
}

}  // namespace
}  // namespace diaphane::render
