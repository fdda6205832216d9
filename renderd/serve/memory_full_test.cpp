// A device with full memory: new sessions are refused with a reason and go elsewhere, and existing
// ones are not affected.
#include <gtest/gtest.h>

#include "renderd/serve/session_host.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;
using Kind = v1::ServerMessage;

struct MemoryFullTest : testing::Test {
  MemoryFullTest() {
    device->seconds_per_megapixel = 0.25;
    options.volume_dir = store.path;
    options.host.slots = 8;
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
  }
  v1::Open opening() const {
    v1::Open open;
    open.set_viewer(v1::VIEWER_OWNER);
    open.set_session_id(new_id());
    open.set_volume_id(volume);
    open.set_placement(1);
    return open;
  }
  // Opens a session and sends the greeting. The link shows the result.
  std::shared_ptr<Link> enter() {
    auto link = std::make_shared<Link>();
    attachments.push_back(worker->host().open(opening(), link));
    EXPECT_TRUE(attachments.back());
    attachments.back()->receive(hello_message().SerializeAsString());
    return link;
  }
  bool shows(Link& link, std::size_t attachment, std::uint64_t input, double by) {
    attachments[attachment]->receive(scene_message(input, turned(scene, by)).SerializeAsString());
    for (;;) {
      const auto frame = link.inbox.next_of(Kind::kFrame);
      if (!frame) return false;
      attachments[attachment]->receive(ack_message(frame->frame().seq()).SerializeAsString());
      if (frame->frame().input_seq() >= input) return true;
    }
  }

  TestStore store;
  std::string volume = store.add_ball();
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SharedManualClock clock;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
  std::vector<Result<Attachment>> attachments;
  v1::Scene scene;
};

TEST_F(MemoryFullTest, RefusesNextSessionAndKeepsTheOthers) {
  auto first = enter();
  const auto config = first->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  scene = config->config().scene();
  ASSERT_TRUE(shows(*first, 0, 1, 1));

  device->refuse_renderers = true;
  auto second = enter();
  const auto ended = second->inbox.ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, ErrorCode::kOutOfMemory);
  const auto problem = second->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_TRUE(problem->problem().fatal());
  EXPECT_FALSE(problem->problem().message().empty());

  // No session is placed here from now on, because the heartbeat reports no free slot.
  EXPECT_TRUE(eventually([&] { return worker->host().slots() == 1; }));
  const auto third = worker->host().open(opening(), std::make_shared<Link>());
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().code, ErrorCode::kOutOfMemory);

  EXPECT_TRUE(shows(*first, 0, 2, 2)) << "the session that was there continues";
}

TEST_F(MemoryFullTest, OutOfMemoryOfTheFirstImageRefusesTheSession) {
  auto first = enter();
  const auto config = first->inbox.next_of(Kind::kConfig);
  ASSERT_TRUE(config);
  scene = config->config().scene();
  ASSERT_TRUE(shows(*first, 0, 1, 1));
  device->refuse_scenes = true;
  auto second = enter();
  const auto ended = second->inbox.ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, ErrorCode::kOutOfMemory);
  EXPECT_TRUE(eventually([&] { return worker->host().slots() == 1; }));
  device->refuse_scenes = false;
  EXPECT_TRUE(shows(*first, 0, 2, 2));
}

TEST_F(MemoryFullTest, RestoresSlotsWhenASessionEndsOrAfterATimeout) {
  auto first = enter();
  ASSERT_TRUE(first->inbox.next_of(Kind::kConfig));
  device->refuse_renderers = true;
  EXPECT_TRUE(enter()->inbox.ended());
  EXPECT_TRUE(eventually([&] { return worker->host().slots() == 1; }));
  clock.advance(options.host.full_for);
  EXPECT_EQ(worker->host().slots(), 8U) << "it is tried again";

  EXPECT_TRUE(enter()->inbox.ended());
  EXPECT_TRUE(eventually([&] { return worker->host().slots() == 1; }));
  worker->host().moved_away(worker->host().live().front().id);
  EXPECT_EQ(worker->host().slots(), 8U);
}

TEST_F(MemoryFullTest, EvictsAbandonedSessionBeforeRefusing) {
  auto first = enter();
  ASSERT_TRUE(first->inbox.next_of(Kind::kConfig));
  attachments[0]->closed();
  device->refuse_renderers = true;
  EXPECT_TRUE(enter()->inbox.ended());
  EXPECT_TRUE(eventually([&] { return worker->host().used() == 0; }));
  EXPECT_EQ(worker->host().slots(), 8U) << "the next request gets the slot";
}

}  // namespace
}  // namespace diaphane::render
