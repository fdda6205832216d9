#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/support/renderd/slice_values.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using Kind = v1::ServerMessage;

struct Viewer : TestViewer {
  std::uint64_t taken = 0;

  void want(std::initializer_list<std::pair<v1::AnatomicalPlane, std::uint32_t>> slices) {
    v1::ClientMessage message;
    v1::SliceRequest& request = *message.mutable_slices();
    for (const auto& [plane, index] : slices) {
      v1::SliceRequest::At& at = *request.add_slices();
      at.set_plane(plane);
      at.set_index(index);
    }
    request.set_taken(taken);
    say(message);
  }
  void want_curved(double x) {
    v1::ClientMessage message;
    v1::CurvedSlice& curved = *message.mutable_slices()->add_slices()->mutable_curved();
    curved.set_id(5);
    curved.set_columns(3);
    curved.set_rows(4);
    // From the front to the back, through the centres of voxels.
    for (const double y : {-0.5, 1.5}) {
      v1::Vec3& point = *curved.add_points();
      point.set_x(x);
      point.set_y(y);
    }
    curved.set_pixel(1);
    message.mutable_slices()->set_taken(taken);
    say(message);
  }
  void let_guests_see_slices(bool on) {
    v1::ClientMessage message;
    message.mutable_guest_slices()->set_on(on);
    say(message);
  }
  void show_slices(bool on) {
    v1::ClientMessage message;
    message.mutable_slice_view()->set_layout(on ? v1::SliceView::FOUR
                                                : v1::SliceView::LAYOUT_UNSPECIFIED);
    say(message);
  }
  std::optional<v1::ExactSlice> slice() {
    const auto message = link->inbox.next_of(Kind::kSlice);
    if (!message) return std::nullopt;
    taken = message->slice().seq();
    return message->slice();
  }
};

struct SessionSlicesTest : WorkerTest {
  SessionSlicesTest() {
    device->seconds_per_megapixel = 0.25;
    options.host.slots = 2;
    stored.header.size = {6, 5, 4};
    stored.header.spacing = {1, 2, 3};
    stored.header.direction = {0, -1, 0, 1, 0, 0, 0, 0, 1};  // x to the back, y to the right
    stored.header.modality = volume::Modality::kCt;
    for (int i = 0; i < 6 * 5 * 4; ++i)
      stored.voxels.push_back(static_cast<std::int16_t>(7 * i - 500));
    volume::measure(stored);
    id = new_id();
    EXPECT_TRUE(volume::write(stored, store.path + "/" + id));
    start_worker();
  }

  Viewer attach(const std::string& session, const std::string& participant = {}) {
    Viewer viewer;
    stacks = enter(viewer, open_message(session, id, participant)).slice_stacks();
    return viewer;
  }
  std::int16_t voxel(std::size_t x, std::size_t y, std::size_t z) const {
    return stored.voxels[x + 6 * (y + 5 * z)];
  }

  volume::Volume stored;
  std::string id;
  google::protobuf::RepeatedPtrField<v1::SliceStack> stacks;
};

TEST_F(SessionSlicesTest, ContainTheStoredVoxels) {
  Viewer one = attach(new_id());
  ASSERT_EQ(stacks.size(), 3);
  EXPECT_EQ(stacks[0].columns(), 5U);
  EXPECT_EQ(stacks[0].rows(), 6U);
  EXPECT_EQ(stacks[0].slices(), 4U);
  EXPECT_DOUBLE_EQ(stacks[0].right().x(), 2);
  one.want({{v1::AXIAL, 2}});
  const auto axial = one.slice();
  ASSERT_TRUE(axial);
  EXPECT_EQ(axial->seq(), 1U);
  EXPECT_EQ(axial->index(), 2U);
  const auto values = values_of(*axial);
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column < 5; ++column) {
      EXPECT_EQ(values[row * 5 + column], voxel(row, 4 - column, 2));
    }
  }
  one.want({{v1::SAGITTAL, 0}, {v1::CORONAL, 5}});
  for (int i = 0; i < 2; ++i) {
    const auto slice = one.slice();
    ASSERT_TRUE(slice);
    const bool sagittal = slice->plane() == v1::SAGITTAL;
    EXPECT_EQ(values_of(*slice).front(), sagittal ? voxel(0, 4, 3) : voxel(5, 4, 3));
  }
}

TEST_F(SessionSlicesTest, HaveTheLabelsOfTheStoredVoxels) {
  volume::LabelSet set{{{3, "Lung", {}}, {9, "Heart", {}}}, {{6, 5, 4}, {}}};
  set.labels.voxels.assign(6 * 5 * 4, 0);
  const auto label = [&](std::size_t x, std::size_t y, std::size_t z) -> std::uint8_t& {
    return set.labels.voxels[x + 6 * (y + 5 * z)];
  };
  label(1, 0, 2) = 1;
  label(4, 3, 2) = 2;
  ASSERT_TRUE(volume::write_label_set(volume::encode(set), store.path + "/" + id));
  Viewer one = attach(new_id());
  one.want({{v1::AXIAL, 2}});
  const auto axial = one.slice();
  ASSERT_TRUE(axial);
  const auto labels = labels_of(*axial);
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column < 5; ++column) {
      EXPECT_EQ(labels[row * 5 + column], label(row, 4 - column, 2)) << row << " " << column;
    }
  }
  one.want({{v1::AXIAL, 1}});
  const auto without = one.slice();
  ASSERT_TRUE(without);
  EXPECT_EQ(without->labels(), "");
}

TEST_F(SessionSlicesTest, CurvedSlicesInterpolateTheStoredVoxels) {
  volume::LabelSet set{{{3, "Lung", {}}}, {{6, 5, 4}, {}}};
  set.labels.voxels.assign(6 * 5 * 4, 1);
  ASSERT_TRUE(volume::write_label_set(volume::encode(set), store.path + "/" + id));
  Viewer one = attach(new_id());
  one.want_curved(0);
  const auto curved = one.slice();
  ASSERT_TRUE(curved);
  EXPECT_EQ(curved->curved(), 5U);
  ASSERT_EQ(curved->columns(), 3U);
  ASSERT_EQ(curved->rows(), 4U);
  const auto values = values_of(*curved);
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 4; ++row) {
      // The curve runs through the middle (x from 2 to 4, y = 2, z = 1.5). Rows lead to the feet
      // and lie 1 mm apart between voxels of 3 mm.
      const double z = 1.5 - (double(row) - 1.5) / 3;
      const double between = 7 * (double(column) + 2 + 6 * (2 + 5 * z)) - 500;
      EXPECT_NEAR(values[row * 3 + column], between, 0.5 + 1e-9) << column << " " << row;
    }
  }
  EXPECT_EQ(labels_of(*curved), std::vector<std::uint8_t>(12, 1));
}

TEST_F(SessionSlicesTest, GuestsGetCurvedSlicesOnlyIfALinkAllowsAllSlicesAndClipped) {
  const std::string session = new_id();
  Viewer owner;
  const v1::Config config = enter(owner, open_message(session, id));
  Viewer follower = attach(session, new_id()), wide;
  v1::Open open = open_message(session, id, new_id());
  open.set_slices(true);
  enter(wide, open);
  follower.want_curved(0);
  EXPECT_EQ(follower.problem()->code(), "forbidden");
  owner.let_guests_see_slices(true);
  owner.show_slices(true);
  follower.want_curved(0);
  follower.want({{v1::AXIAL, 1}});
  const auto shown = follower.slice();
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->curved(), 0U) << "only what the presenter shows";
  v1::Scene scene = config.scene();
  v1::Clip::Plane& plane = *scene.mutable_clip()->add_planes();
  plane.mutable_point();
  plane.mutable_normal()->set_x(1);  // removes the patient's left half
  owner.say(scene_message(1, scene));
  wide.want_curved(4);
  const auto clipped = wide.slice();
  ASSERT_TRUE(clipped);
  EXPECT_EQ(clipped->curved(), 5U);
  EXPECT_EQ(values_of(*clipped), std::vector<std::int16_t>(12, volume::kBlank));
}

TEST_F(SessionSlicesTest, EachViewerGetsOnlyItsOwnSlices) {
  const std::string session = new_id();
  Viewer owner = attach(session);
  Viewer guest = attach(session, new_id());
  owner.let_guests_see_slices(true);
  owner.show_slices(true);
  guest.want({{v1::AXIAL, 1}});
  const auto slice = guest.slice();
  ASSERT_TRUE(slice);
  EXPECT_EQ(slice->index(), 1U);
  owner.want({{v1::AXIAL, 3}});
  ASSERT_TRUE(owner.slice());
  EXPECT_EQ(owner.link->inbox.count(Kind::kSlice), 1U);
  EXPECT_EQ(guest.link->inbox.count(Kind::kSlice), 1U);
}

TEST_F(SessionSlicesTest, GuestsGetSlicesOnlyWhileAllowed) {
  const std::string session = new_id();
  Viewer owner = attach(session);
  Viewer guest = attach(session, new_id());
  const auto refused = [&] {
    guest.want({{v1::AXIAL, 1}});
    const auto problem = guest.problem();
    return problem && problem->code() == "forbidden" && problem->field() == "slices" &&
           !problem->fatal();
  };
  EXPECT_TRUE(refused());
  guest.let_guests_see_slices(true);
  EXPECT_EQ(guest.problem()->field(), "guest_slices");
  EXPECT_TRUE(refused());
  owner.let_guests_see_slices(true);
  EXPECT_TRUE(refused()) << "the presenter shows none";
  owner.show_slices(true);
  guest.want({{v1::AXIAL, 1}});
  EXPECT_TRUE(guest.slice());
  owner.show_slices(false);
  EXPECT_TRUE(refused());
  owner.show_slices(true);
  owner.let_guests_see_slices(false);
  EXPECT_TRUE(refused());
  EXPECT_EQ(guest.link->inbox.count(Kind::kSlice), 1U);
}

TEST_F(SessionSlicesTest, GuestSlicesAreClippedAndBecomeStaleOnChange) {
  const std::string session = new_id();
  Viewer owner;
  const v1::Config config = enter(owner, open_message(session, id));
  Viewer guest = attach(session, new_id());
  owner.let_guests_see_slices(true);
  owner.show_slices(true);
  v1::Scene scene = config.scene();
  v1::Clip::Plane& plane = *scene.mutable_clip()->add_planes();
  plane.mutable_point();
  plane.mutable_normal()->set_x(1);  // removes the patient's left half
  owner.say(scene_message(1, scene));
  guest.want({{v1::AXIAL, 2}});
  const auto clipped = guest.slice();
  ASSERT_TRUE(clipped);
  const auto values = values_of(*clipped);
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column < 5; ++column) {
      // Columns run to the patient's left, and the centres of the middle one lie on the plane.
      EXPECT_EQ(values[row * 5 + column], column <= 2 ? voxel(row, 4 - column, 2) : volume::kBlank);
    }
  }
  scene.clear_clip();
  owner.say(scene_message(2, scene));
  EXPECT_TRUE(guest.link->inbox.next_of(Kind::kSlicesStale));
  guest.want({{v1::AXIAL, 2}});
  const auto whole = guest.slice();
  ASSERT_TRUE(whole);
  EXPECT_EQ(values_of(*whole)[4], voxel(0, 0, 2));
  // The owner's slices are complete whatever is clipped, and never stale.
  EXPECT_EQ(owner.link->inbox.count(Kind::kSlicesStale), 0U);
}

TEST_F(SessionSlicesTest, RefuseViewersWithoutGreeting) {
  Viewer silent;
  silent.attachment.emplace(*worker->host().open(open_message(new_id(), id), silent.link));
  silent.want({{v1::AXIAL, 1}});
  EXPECT_TRUE(silent.link->inbox.ended());
  EXPECT_EQ(silent.link->inbox.count(Kind::kSlice), 0U);
}

TEST_F(SessionSlicesTest, GuestsDoNotGetStatisticsOfTheWholeVolume) {
  const std::string session = new_id();
  Viewer owner, guest;
  const v1::Config whole = enter(owner, open_message(session, id));
  const v1::Config guest_config = enter(guest, open_message(session, id, new_id()));
  EXPECT_FALSE(whole.volume().content_hash().empty());
  EXPECT_TRUE(guest_config.volume().content_hash().empty());
  EXPECT_EQ(guest_config.volume().percentiles_size(), 0);
  EXPECT_FALSE(guest_config.has_histogram());
}

TEST_F(SessionSlicesTest, InvalidRequestIsRefusedAndTheSessionContinues) {
  Viewer one = attach(new_id());
  one.want({{v1::AXIAL, 4}});
  const auto problem = one.problem();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code(), "invalid");
  EXPECT_EQ(problem->field(), "slices[0].index");
  EXPECT_FALSE(problem->fatal());
  const auto frame = one.link->inbox.next_of(Kind::kFrame);
  ASSERT_TRUE(frame);
  one.say(ack_message(frame->frame().seq()));
  EXPECT_TRUE(one.link->inbox.next_of(Kind::kFrame));
  one.want({{v1::AXIAL, 3}});
  EXPECT_TRUE(one.slice());
}

/// A viewer who takes none has three in transit, and the others continue.
TEST_F(SessionSlicesTest, StalledViewerHasThreeInFlightAndDelaysNobody) {
  const std::string session = new_id();
  Viewer silent = attach(session), other;
  v1::Open open = open_message(session, id, new_id());
  open.set_slices(true);  // a guest whose link allows all slices
  enter(other, open);
  for (std::uint32_t i = 0; i < 200; ++i) {
    v1::ClientMessage message;
    v1::SliceRequest::At& at = *message.mutable_slices()->add_slices();
    at.set_plane(v1::AXIAL);
    at.set_index(i % 4);
    silent.say(message);
  }
  for (std::uint32_t i = 0; i < 20; ++i) {
    other.want({{v1::CORONAL, i % 6}});
    const auto slice = other.slice();
    ASSERT_TRUE(slice);
    EXPECT_EQ(slice->index(), i % 6);
  }
  EXPECT_LE(silent.link->inbox.count(Kind::kSlice), 3U);
}

TEST_F(SessionSlicesTest, RefuseSlicesOfAReplacedVolume) {
  Viewer one = attach(new_id());
  volume::Volume cut = stored;
  std::fill(cut.voxels.begin(), cut.voxels.end(), std::int16_t{-1000});
  volume::measure(cut);
  ASSERT_TRUE(volume::replace(cut, store.path + "/" + id, [] { return Result<void>(); }));
  one.want({{v1::AXIAL, 0}});
  const auto said = one.link->inbox.next(
      [](const auto& message) { return message.has_problem() || message.has_slice(); });
  ASSERT_TRUE(said);
  EXPECT_TRUE(said->has_problem());
}

}  // namespace
}  // namespace diaphane::render
