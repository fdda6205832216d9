// Sessions that show two scans: both are loaded before the first picture, and either ends them.
#include <gtest/gtest.h>

#include "renderd/serve/session_host.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/slice_values.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using Kind = v1::ServerMessage;

constexpr std::uint64_t kBytes = 2 * 24 * 24 * 24;

struct SessionSecondTest : testing::Test {
  void start(std::uint64_t bytes = 4 * kBytes) {
    device->seconds_per_megapixel = 0.01;
    options.volume_dir = store.path;
    options.volume_bytes = bytes;
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
    open.set_viewer(v1::VIEWER_OWNER);
    open.set_session_id(new_id());
    open.set_volume_id(first);
    open.set_placement(1);
    open.mutable_second()->set_volume_id(second);
    const std::array<double, 16> motion{1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    for (const double number : motion) open.mutable_second()->add_to_first(number);
  }
  std::optional<v1::Config> config(v1::Viewer viewer = v1::VIEWER_OWNER) {
    open.set_viewer(viewer);
    attachment = worker->host().open(open, link);
    EXPECT_TRUE(attachment) << attachment.error().message;
    if (!attachment) return std::nullopt;
    attachment->receive(hello_message().SerializeAsString());
    const auto message = link->inbox.next_of(Kind::kConfig);
    return message ? std::optional(message->config()) : std::nullopt;
  }

  TestStore store;
  std::string first = store.add_ball(), second = store.add_ball(20);
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SharedManualClock clock;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
  std::shared_ptr<Link> link = std::make_shared<Link>();
  v1::Open open;
  Result<Attachment> attachment = fail(ErrorCode::kInternal, "not opened");
};

TEST_F(SessionSecondTest, LoadsBothScansAndShowsTheSecondByDefault) {
  start();
  const auto found = config();
  ASSERT_TRUE(found);
  ASSERT_TRUE(found->has_second());
  EXPECT_EQ(found->volume().size(0), 24u);
  EXPECT_EQ(found->second().volume().size(0), 20u);
  EXPECT_GT(found->second().histogram().counts_size(), 0);
  ASSERT_GT(found->second().looks_size(), 0);
  EXPECT_EQ(found->scene().overlay().SerializeAsString(),
            found->second().looks(0).overlay().SerializeAsString());
  const auto shown = device->second.lock();
  ASSERT_TRUE(shown) << "the renderer has it";
  EXPECT_EQ(shown->header().size[0], 20u);
  EXPECT_EQ(device->to_first[3], 5);
  EXPECT_EQ(device->volumes, 2);
  EXPECT_TRUE(link->inbox.next_of(Kind::kFrame));
}

TEST_F(SessionSecondTest, GuestsLearnNoValuesOfTheSecondScan) {
  start();
  const auto found = config(v1::VIEWER_LIVE_GUEST);
  ASSERT_TRUE(found && found->has_second());
  EXPECT_EQ(found->second().histogram().counts_size(), 0);
  EXPECT_EQ(found->second().volume().percentiles_size(), 0);
  EXPECT_TRUE(found->second().volume().content_hash().empty());
}

TEST_F(SessionSecondTest, SessionsOfOneScanHaveNone) {
  start();
  open.clear_second();
  const auto found = config();
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->has_second());
  EXPECT_FALSE(found->scene().has_overlay());
  EXPECT_FALSE(device->second.lock());
}

TEST_F(SessionSecondTest, EndsIfBothDoNotFit) {
  start(kBytes + kBytes / 3);
  attachment = worker->host().open(open, link);
  ASSERT_TRUE(attachment);
  attachment->receive(hello_message().SerializeAsString());
  const auto ended = link->inbox.ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, ErrorCode::kOutOfMemory);
}

TEST_F(SessionSecondTest, EndsIfTheSecondScanIsMissing) {
  start();
  open.mutable_second()->set_volume_id(new_id());
  attachment = worker->host().open(open, link);
  ASSERT_TRUE(attachment);
  const auto ended = link->inbox.ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, ErrorCode::kNotFound);
}

TEST_F(SessionSecondTest, EndsWithEitherScan) {
  for (const bool with_first : {true, false}) {
    start();
    link = std::make_shared<Link>();
    ASSERT_TRUE(config());
    worker->host().volume_gone(new_id());
    EXPECT_EQ(worker->host().used(), 1u);
    worker->host().volume_gone(with_first ? first : second);
    const auto ended = link->inbox.ended();
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->code, ErrorCode::kNotFound);
    worker.reset();
    open.Clear();
  }
}

TEST_F(SessionSecondTest, RefusesAnotherSecondScanAndMotionsThatAreNotRigid) {
  start();
  ASSERT_TRUE(config());
  v1::Open other = open;
  other.clear_second();
  EXPECT_EQ(worker->host().open(other, std::make_shared<Link>()).error().code, ErrorCode::kInvalid);
  other = open;
  other.set_session_id(new_id());
  other.mutable_second()->set_to_first(0, 2);
  EXPECT_EQ(worker->host().open(other, std::make_shared<Link>()).error().field, "alignment");
  other = open;
  other.mutable_second()->set_volume_id("../x");
  EXPECT_EQ(worker->host().open(other, std::make_shared<Link>()).error().field, "second.volume_id");
}

TEST_F(SessionSecondTest, SlicesHaveTheValuesOfBothScans) {
  start();
  open.mutable_second()->clear_to_first();
  ASSERT_TRUE(config());
  v1::ClientMessage request;
  auto& at = *request.mutable_slices()->add_slices();
  at.set_plane(v1::AXIAL);
  at.set_index(12);
  attachment->receive(request.SerializeAsString());
  const auto message = link->inbox.next_of(Kind::kSlice);
  ASSERT_TRUE(message);
  const v1::ExactSlice& slice = message->slice();
  ASSERT_FALSE(slice.second().empty());
  const auto values = values_of(slice, slice.second());
  const std::size_t middle = 12 + 24 * 12;
  EXPECT_EQ(values.at(middle), 1200);
  // 20 of 24 voxels of 4 mm: the second scan ends two voxels before the first.
  EXPECT_EQ(values.at(0), -32768);
  EXPECT_EQ(values.at(2 + 24 * 2), -1000);
}

}  // namespace
}  // namespace diaphane::render
