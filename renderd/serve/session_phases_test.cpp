// Scans with several phases: a session shows the phase of its scene, loads all phases if they fit,
// and otherwise those that are shown.
#include <gtest/gtest.h>

#include "renderd/serve/session_host.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using Kind = v1::ServerMessage;

constexpr std::uint32_t kPhases = 4;
constexpr std::uint64_t kPhaseBytes = 2 * 24 * 24 * 24;

struct SessionPhasesTest : testing::Test {
  void open(std::uint64_t bytes) {
    device->seconds_per_megapixel = 0.01;
    options.volume_dir = store.path;
    options.volume_bytes = bytes;
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
    v1::Open open;
    open.set_viewer(v1::VIEWER_OWNER);
    open.set_session_id(new_id());
    open.set_volume_id(volume);
    open.set_placement(1);
    attachment = worker->host().open(open, link);
    ASSERT_TRUE(attachment);
    attachment->receive(hello_message().SerializeAsString());
    const auto config = link->inbox.next_of(Kind::kConfig);
    ASSERT_TRUE(config);
    ASSERT_EQ(config->config().volume().phases_size(), static_cast<int>(kPhases));
    EXPECT_EQ(config->config().volume().phases(1).value(), 25);
    scene = config->config().scene();
  }
  bool reports(std::uint32_t loaded, bool fit) {
    return link->inbox
        .next([&](const auto& message) {
          return message.has_volume_phases() && message.volume_phases().fit() == fit &&
                 message.volume_phases().loaded() == loaded;
        })
        .has_value();
  }
  /// Returns the phase of the first frame that answers a scene with this phase.
  std::uint32_t shown(std::uint32_t phase) {
    scene.set_volume_phase(phase);
    attachment->receive(scene_message(++input, scene).SerializeAsString());
    for (;;) {
      const auto frame = link->inbox.next_of(Kind::kFrame);
      if (!frame) return ~0u;
      attachment->receive(ack_message(frame->frame().seq()).SerializeAsString());
      if (frame->frame().input_seq() >= input) return frame->frame().volume_phase();
    }
  }

  TestStore store;
  std::string volume = store.add_ball(24, kPhases);
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SharedManualClock clock;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
  std::shared_ptr<Link> link = std::make_shared<Link>();
  Result<Attachment> attachment = fail(ErrorCode::kInternal, "not opened");
  v1::Scene scene;
  std::uint64_t input = 0;
};

TEST_F(SessionPhasesTest, LoadsAllPhasesThatFitAndThenOnlyShowsThem) {
  open(kPhases * kPhaseBytes);
  ASSERT_TRUE(reports(kPhases, true));
  for (const std::uint32_t phase : {2u, 3u, 0u, 1u}) EXPECT_EQ(shown(phase), phase);
  EXPECT_EQ(device->volumes, static_cast<int>(kPhases)) << "each was loaded once";
}

TEST_F(SessionPhasesTest, ShowsEveryPhaseAlthoughNotAllFit) {
  open(2 * kPhaseBytes);
  ASSERT_TRUE(reports(1, false));
  for (const std::uint32_t phase : {3u, 1u, 2u, 0u, 3u}) EXPECT_EQ(shown(phase), phase);
  EXPECT_GT(device->volumes, static_cast<int>(kPhases));
}

TEST_F(SessionPhasesTest, ShowsTheLastPhaseBeyondIt) {
  open(kPhases * kPhaseBytes);
  ASSERT_TRUE(reports(kPhases, true));
  shown(17);
  EXPECT_EQ(device->volumes, static_cast<int>(kPhases)) << "it is a phase that is loaded";
}

TEST_F(SessionPhasesTest, ReportsAPhaseThatCannotBeLoadedAndKeepsTheShownOne) {
  open(2 * kPhaseBytes);
  ASSERT_TRUE(reports(1, false));
  EXPECT_EQ(shown(0), 0u);
  std::filesystem::remove(store.path + "/" + volume + "/voxels.i16");
  scene.set_volume_phase(2);
  attachment->receive(scene_message(++input, scene).SerializeAsString());
  const auto problem = link->inbox.next_of(Kind::kProblem);
  ASSERT_TRUE(problem);
  EXPECT_FALSE(problem->problem().fatal());
  EXPECT_EQ(problem->problem().input_seq(), input);
}

}  // namespace
}  // namespace diaphane::render
