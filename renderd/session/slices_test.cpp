#include "renderd/session/slices.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::CodeSlice;
using effect::LoadVoxels;
using effect::Send;

struct SlicesTest : testing::Test {
  SlicesTest() {
    volume::Volume voxels;
    voxels.header.size = {30, 20, 10};
    voxels.header.content_hash = "hash";
    volume = std::make_shared<const HostVolume>(std::move(voxels));
    slices.handle(SlicesKnown{stacks_of(volume->header()), volume->header()});
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    connection = attach(state, owner(), now)->connection;
    slices.handle(SceneChanged{}, state, now);
  }
  std::uint64_t guest() {
    JoinRequest join;
    join.participant = "guest";
    state.audience.guest_slices = true;
    show(3);
    return attach(state, join, now)->connection;
  }
  /// Shows an axial slice, and the slices of the other planes at the edge of the volume.
  void show(std::uint32_t index, v1::SliceView::Layout layout = v1::SliceView::FOUR,
            v1::AnatomicalPlane plane = v1::AXIAL) {
    const volume::SliceStack& axial = slices.stacks()->front();
    v1::SliceView view;
    view.set_layout(layout);
    view.set_plane(plane);
    view.mutable_crosshair()->set_x(axial.first[0] + index * axial.next[0]);
    view.mutable_crosshair()->set_y(axial.first[1] + index * axial.next[1]);
    view.mutable_crosshair()->set_z(axial.first[2] + index * axial.next[2]);
    state.audience.show(view, now);
  }
  Effects ask(std::uint64_t from, std::uint32_t index) {
    v1::SliceRequest request;
    request.add_slices()->set_plane(v1::AXIAL);
    request.mutable_slices(0)->set_index(index);
    return slices.handle(SlicesRequested{from, request}, state, now);
  }
  Effects load(const std::string& hash = "hash") {
    return slices.handle(VoxelsLoaded{volume, hash}, state, now);
  }
  Effects load_phase(std::uint32_t phase) {
    volume::Volume voxels = volume->volume();
    voxels.phase = phase;
    return slices.handle(
        VoxelsLoaded{std::make_shared<const HostVolume>(std::move(voxels)), "hash"}, state, now);
  }
  Effects coded(const CodeSlice& of) {
    return slices.handle(SliceCoded{of.connection, of.order, std::string("data")}, state, now);
  }
  void clip_scene() {
    v1::Scene clipped = *state.requested.scene;
    clipped.mutable_clip()->mutable_box_low()->set_x(1);
    state.requested.scene = std::make_shared<const v1::Scene>(clipped);
  }

  TimePoint now = TimePoint() + std::chrono::seconds(100);
  SessionState state;
  Slices slices;
  std::shared_ptr<const HostVolume> volume;
  std::uint64_t connection = 0;
};

TEST_F(SlicesTest, LoadsVoxelsOnceAndThenCodesWhatEachViewerWaitsFor) {
  const std::uint64_t other = guest();
  sole<LoadVoxels>(ask(connection, 3));
  EXPECT_TRUE(ask(other, 3).empty());
  const auto orders = only<CodeSlice>(load());
  ASSERT_EQ(orders.size(), 2u);
  EXPECT_EQ(orders[0].connection, connection);
  EXPECT_EQ(orders[0].order.due.index, 3u);
  EXPECT_FALSE(orders[0].for_guest);
  EXPECT_FALSE(orders[0].order.clip);
  EXPECT_EQ(orders[1].connection, other);
  EXPECT_TRUE(orders[1].for_guest);
  EXPECT_TRUE(orders[1].order.clip);
}

TEST_F(SlicesTest, SendsCodedSliceAndTakesNewestRequestNext) {
  ask(connection, 3);
  const auto first = sole<CodeSlice>(load());
  EXPECT_TRUE(ask(connection, 5).empty());  // one at a time
  const Effects effects = coded(first);
  const auto sent = only<Send>(effects);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].message.slice().index(), 3u);
  EXPECT_EQ(sent[0].message.slice().data(), "data");
  ASSERT_EQ(only<CodeSlice>(effects).size(), 1u);
  EXPECT_EQ(only<CodeSlice>(effects)[0].order.due.index, 5u);
}

TEST_F(SlicesTest, OnlyViewersWhoMayKnowLabelsGetThem) {
  const std::uint64_t other = guest();
  ask(connection, 3);
  ask(other, 3);
  const auto orders = only<CodeSlice>(load());
  ASSERT_EQ(orders.size(), 2u);
  EXPECT_TRUE(orders[0].with_labels);
  EXPECT_FALSE(orders[1].with_labels);
  const auto sent = slices.handle(
      SliceCoded{connection, orders[0].order, std::string("data"), {}, "labels"}, state, now);
  EXPECT_EQ(only<Send>(sent).at(0).message.slice().labels(), "labels");
}

TEST_F(SlicesTest, NewLabelsMakeTheSlicesOfTheirViewersStale) {
  const std::uint64_t other = guest();
  ask(connection, 3);
  ask(other, 3);
  for (const CodeSlice& order : only<CodeSlice>(load())) coded(order);
  const auto stale = only<Send>(slices.handle(LabelsReplaced{}, state));
  ASSERT_EQ(stale.size(), 1u) << "guests see no labels";
  EXPECT_EQ(stale[0].connection, connection);
  EXPECT_TRUE(stale[0].message.has_slices_stale());
  sole<LoadVoxels>(ask(connection, 4));
}

TEST_F(SlicesTest, RebuildsSliceIfTheClipChangedMeanwhile) {
  const std::uint64_t other = guest();
  ask(other, 3);
  const auto order = sole<CodeSlice>(load());
  clip_scene();
  const auto again = sole<CodeSlice>(coded(order));
  EXPECT_EQ(again.order.due.index, 3u);
  EXPECT_TRUE(again.order.clip->has_box_low());
}

/// The presenter shows tilted planes, and requests name them as the page does.
struct ObliqueSlicesTest : SlicesTest {
  void show_tilted(double slab = 0) {
    v1::SliceView view;
    view.set_layout(v1::SliceView::FOUR);
    v1::SliceView::Tilt& tilt = *view.add_tilts();
    tilt.set_plane(v1::AXIAL);
    tilt.mutable_right()->set_x(0.8);
    tilt.mutable_right()->set_z(0.6);
    tilt.mutable_down()->set_y(1);
    view.set_slab(slab);
    view.set_projection(v1::PROJECTION_MAXIMUM);
    state.audience.show(view, now);
  }
  /// An axial plane turned about y, `off` mm from the centre of the volume.
  static v1::SliceRequest tilted(double off = 0, double slab = 0) {
    v1::SliceRequest request;
    auto& at = *request.add_slices();
    at.set_plane(v1::AXIAL);
    v1::ObliqueSlice& oblique = *at.mutable_oblique();
    oblique.set_id(7);
    oblique.set_columns(8);
    oblique.set_rows(8);
    // The normal is (-0.6, 0, 0.8).
    oblique.mutable_first()->set_x(-0.6 * off);
    oblique.mutable_first()->set_z(0.8 * off);
    oblique.mutable_right()->set_x(0.8);
    oblique.mutable_right()->set_z(0.6);
    oblique.mutable_down()->set_y(1);
    oblique.set_thickness(slab);
    oblique.set_projection(v1::PROJECTION_MAXIMUM);
    return request;
  }
  bool gets(std::uint64_t who, const v1::SliceRequest& request) {
    const Effects effects = slices.handle(SlicesRequested{who, request}, state, now);
    const auto orders = only<CodeSlice>(effects);
    if (orders.empty()) return false;
    coded(orders.front());
    return true;
  }
};

TEST_F(ObliqueSlicesTest, AreSentWithTheirOwnSizeAndId) {
  slices.handle(SlicesRequested{connection, tilted()}, state, now);
  const auto order = sole<CodeSlice>(load());
  ASSERT_TRUE(order.order.due.oblique);
  const auto sent = only<Send>(coded(order));
  ASSERT_EQ(sent.size(), 1u);
  const v1::ExactSlice& slice = sent[0].message.slice();
  EXPECT_EQ(slice.oblique(), 7u);
  EXPECT_EQ(slice.columns(), 8u);
  EXPECT_EQ(slice.rows(), 8u);
}

TEST_F(ObliqueSlicesTest, GuestsGetOnlyThePlaneThatThePresenterShows) {
  const std::uint64_t other = guest();
  slices.handle(SlicesRequested{connection, tilted()}, state, now);
  coded(sole<CodeSlice>(load()));
  EXPECT_FALSE(gets(other, tilted())) << "the presenter's planes are not tilted";
  show_tilted();
  now += std::chrono::seconds(10);  // what was shown before no longer counts
  EXPECT_TRUE(gets(other, tilted()));
  EXPECT_FALSE(gets(other, tilted(1))) << "beside it";
  EXPECT_FALSE(gets(other, tilted(0, 3))) << "a slab around it";
  v1::SliceRequest steeper = tilted();
  steeper.mutable_slices(0)->mutable_oblique()->mutable_right()->set_z(0.601);
  EXPECT_FALSE(gets(other, steeper));
  v1::SliceRequest straight;
  straight.add_slices()->set_plane(v1::AXIAL);
  EXPECT_FALSE(gets(other, straight)) << "a slice of the stack";
  show_tilted(3);
  now += std::chrono::seconds(10);
  EXPECT_TRUE(gets(other, tilted(0, 3)));
  EXPECT_FALSE(gets(other, tilted()));
}

TEST_F(ObliqueSlicesTest, GuestsWithoutSlicesGetNone) {
  const std::uint64_t other = guest();
  show_tilted();
  state.audience.guest_slices = false;
  now += std::chrono::seconds(10);
  slices.handle(SlicesRequested{connection, tilted()}, state, now);
  coded(sole<CodeSlice>(load()));
  EXPECT_FALSE(gets(other, tilted()));
}

/// Requests a slice along a line, and the presenter shows axial slice 3.
struct CurvedSlicesTest : ObliqueSlicesTest {
  static v1::SliceRequest along(double angle = 0) {
    v1::SliceRequest request;
    v1::CurvedSlice& curved = *request.add_slices()->mutable_curved();
    curved.set_id(9);
    curved.set_columns(11);
    curved.set_rows(7);
    curved.add_points()->set_x(-5);
    curved.add_points()->set_x(5);
    curved.set_pixel(1);
    curved.set_angle(angle);
    return request;
  }
};

TEST_F(CurvedSlicesTest, AreSentWithTheirOwnSizeAndId) {
  slices.handle(SlicesRequested{connection, along()}, state, now);
  const auto order = sole<CodeSlice>(load());
  ASSERT_TRUE(order.order.due.curved);
  EXPECT_FALSE(order.order.clip);
  const auto sent = only<Send>(coded(order));
  ASSERT_EQ(sent.size(), 1u);
  const v1::ExactSlice& slice = sent[0].message.slice();
  EXPECT_EQ(slice.curved(), 9u);
  EXPECT_EQ(slice.plane(), v1::ANATOMICAL_PLANE_UNSPECIFIED);
  EXPECT_EQ(slice.oblique(), 0u);
  EXPECT_EQ(slice.columns(), 11u);
  EXPECT_EQ(slice.rows(), 7u);
}

TEST_F(CurvedSlicesTest, GuestsWhoMayOnlySeeWhatIsShownGetNone) {
  const std::uint64_t other = guest();
  ask(connection, 3);
  coded(sole<CodeSlice>(load()));
  show(0);
  v1::SliceRequest first;
  first.add_slices()->set_plane(v1::AXIAL);
  EXPECT_TRUE(gets(other, first));
  EXPECT_FALSE(gets(other, along())) << "in the place of the first slice, which is shown";
  show_tilted();
  EXPECT_FALSE(gets(other, along()));
  EXPECT_TRUE(gets(connection, along()));
}

TEST_F(CurvedSlicesTest, GuestsWithAllSlicesGetClippedOnes) {
  JoinRequest join;
  join.participant = "wide";
  join.may_have_slices = true;
  const std::uint64_t widened = attach(state, join, now)->connection;
  clip_scene();
  slices.handle(SlicesRequested{widened, along()}, state, now);
  const auto order = sole<CodeSlice>(load());
  ASSERT_TRUE(order.order.clip);
  EXPECT_TRUE(order.order.clip->has_box_low());
  EXPECT_TRUE(order.for_guest);
}

TEST_F(CurvedSlicesTest, CostTheirSamples) {
  ask(connection, 3);
  coded(sole<CodeSlice>(load()));
  v1::SliceRequest large = along();
  v1::CurvedSlice& curved = *large.mutable_slices(0)->mutable_curved();
  curved.set_pixel(0.005);
  curved.set_columns(2000);
  curved.set_rows(2000);
  // 4 million samples cost 15 slices, and 120 slices may be sent at once.
  int sent = 0;
  for (; sent < 100; ++sent) {
    curved.set_angle(sent);
    if (!gets(connection, large)) break;
    large.set_taken(large.taken() + 1);
  }
  EXPECT_GE(sent, 6);
  EXPECT_LE(sent, 9);
}

TEST_F(SlicesTest, SendsNothingToGuestsWithoutSliceAccess) {
  const std::uint64_t other = guest();
  ask(other, 3);
  const auto order = sole<CodeSlice>(load());
  state.audience.guest_slices = false;
  EXPECT_TRUE(coded(order).empty());
}

TEST_F(SlicesTest, GuestsGetOnlyTheSlicesThatThePresenterShows) {
  const std::uint64_t other = guest();
  ask(connection, 0);
  load();
  for (std::uint32_t index = 0; index < 10; ++index) {
    EXPECT_EQ(only<CodeSlice>(ask(other, index)).size(), index == 3 ? 1u : 0u) << index;
  }
  coded(CodeSlice{other, {{0, 3}, plain_scene().clip()}, {}, nullptr, true});
  show(4);
  state.audience.slices_before.clear();
  EXPECT_TRUE(ask(other, 3).empty());
  const auto order = sole<CodeSlice>(ask(other, 4));
  show(5);
  state.audience.slices_before.clear();
  EXPECT_TRUE(only<Send>(coded(order)).empty()) << "the presenter has moved on";
  show(4, v1::SliceView::PICTURE);
  now += kShownBefore;
  EXPECT_TRUE(ask(other, 4).empty()) << "only the picture is shown";
  show(4, v1::SliceView::SLICE, v1::CORONAL);
  EXPECT_TRUE(ask(other, 4).empty()) << "only another plane is shown";
  show(4, v1::SliceView::SLICE);
  EXPECT_EQ(sole<CodeSlice>(ask(other, 4)).connection, other);
}

TEST_F(SlicesTest, AGuestWithASlowConnectionGetsSlicesThatWereShownJustBefore) {
  const std::uint64_t other = guest();
  ask(connection, 0);
  load();
  show(4);
  now += kShownBefore - std::chrono::milliseconds(1);
  coded(sole<CodeSlice>(ask(other, 3)));
  now += std::chrono::milliseconds(1);
  EXPECT_TRUE(ask(other, 3).empty());
  for (int i = 0; i < 100; ++i) show(4);
  EXPECT_EQ(state.audience.slices_before.size(), kMostShownBefore);
  show(5);
  state.audience.show({}, now);
  show(6);
  EXPECT_TRUE(ask(other, 5).empty()) << "closing the slices ends it";
}

TEST_F(SlicesTest, ALinkCanAllowItsGuestsAllSlices) {
  JoinRequest join;
  join.participant = "wide";
  join.may_have_slices = true;
  const std::uint64_t widened = attach(state, join, now)->connection;
  const std::uint64_t other = guest();
  ask(connection, 0);
  load();
  EXPECT_TRUE(ask(other, 7).empty());
  const auto order = sole<CodeSlice>(ask(widened, 7));
  EXPECT_TRUE(order.order.clip) << "the clip applies to them, too";
  state.audience.show({}, now);
  state.audience.guest_slices = false;
  EXPECT_EQ(only<Send>(coded(order)).size(), 1u);
}

TEST_F(SlicesTest, NotifiesOnlyViewersWithClippedSlicesOfStaleOnes) {
  const std::uint64_t other = guest();
  ask(other, 3);
  coded(sole<CodeSlice>(load()));
  EXPECT_TRUE(slices.handle(SceneChanged{}, state, now).empty());
  clip_scene();
  const auto stale = sole<Send>(slices.handle(SceneChanged{}, state, now));
  EXPECT_EQ(stale.connection, other);
  EXPECT_TRUE(stale.message.has_slices_stale());
}

TEST_F(SlicesTest, SlicesFollowThePhaseOnceItIsNotPlayed) {
  volume::Header header = volume->header();
  header.phases.resize(10);
  slices.handle(SlicesKnown{stacks_of(header), header});
  const auto show = [&](std::uint32_t phase) {
    auto scene = std::make_shared<v1::Scene>(*state.requested.scene);
    scene->set_volume_phase(phase);
    state.requested.scene = std::move(scene);
    return slices.handle(SceneChanged{}, state, now);
  };
  ask(connection, 3);
  coded(sole<CodeSlice>(load()));
  EXPECT_TRUE(sole<Send>(show(4)).message.has_slices_stale()) << "chosen";
  EXPECT_EQ(sole<LoadVoxels>(ask(connection, 4)).phase, 4u);
  coded(sole<CodeSlice>(load_phase(4)));
  for (std::uint32_t phase = 5; phase < 8; ++phase) {
    now += std::chrono::milliseconds(40);
    EXPECT_TRUE(show(phase).empty()) << "played";
  }
  now += std::chrono::milliseconds(499);
  EXPECT_TRUE(slices.handle(SlicesTicked{}, state, now).empty());
  now += std::chrono::milliseconds(1);
  EXPECT_TRUE(sole<Send>(slices.handle(SlicesTicked{}, state, now)).message.has_slices_stale());
  EXPECT_TRUE(slices.handle(SlicesTicked{}, state, now).empty()) << "said once";
}

TEST_F(SlicesTest, RefusesVoxelsOfReplacedVolume) {
  ask(connection, 3);
  const Effects effects = load("other hash");
  ASSERT_EQ(only<Send>(effects).size(), 1u);
  EXPECT_EQ(only<Send>(effects)[0].message.problem().field(), "slices");
  EXPECT_EQ(only<effect::Warn>(effects).size(), 1u);
  sole<LoadVoxels>(ask(connection, 3));
}

TEST_F(SlicesTest, ForgetsVoxelsWithLastViewer) {
  ask(connection, 3);
  load();
  slices.handle(AllViewersLeft{});
  sole<LoadVoxels>(ask(connection, 4));
}

TEST_F(SlicesTest, RequestOverItsLimitWaitsForTick) {
  ask(connection, 0);
  CodeSlice order = sole<CodeSlice>(load());
  Effects next;
  std::uint64_t sent = 0;
  do {
    v1::SliceRequest request;
    request.add_slices()->set_plane(v1::AXIAL);
    request.mutable_slices(0)->set_index(order.order.due.index == 0 ? 1 : 0);
    coded(order);
    request.set_taken(++sent);
    next = slices.handle(SlicesRequested{connection, request}, state, now);
    if (!next.empty()) order = sole<CodeSlice>(next);
  } while (!next.empty() && sent < 1000);
  EXPECT_EQ(sent, SliceAllowance::kMostASecond);
  EXPECT_TRUE(slices.handle(SlicesTicked{}, state, now).empty());
  now += std::chrono::seconds(1);
  sole<CodeSlice>(slices.handle(SlicesTicked{}, state, now));
}

}  // namespace
}  // namespace diaphane::render
