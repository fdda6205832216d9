#include "renderd/session/collaboration.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "scene/annotations.h"
#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::FindPointer;
using effect::Send;
using std::chrono::milliseconds;
using std::chrono::seconds;

struct CollaborationTest : testing::Test {
  CollaborationTest() {
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    state.audience.slices_shown.layout = v1::SliceView::FOUR;
    presenter = greet(owner());
  }
  std::uint64_t greet(const JoinRequest& join) {
    const std::uint64_t connection = attach(state, join, now)->connection;
    receive(state, connection, hello(), now);
    return connection;
  }
  std::uint64_t join(const std::string& participant, ViewerKind viewer = ViewerKind::kGuest) {
    JoinRequest join;
    join.participant = participant;
    join.viewer = viewer;
    join.may_have_slices = viewer == ViewerKind::kShared;
    return greet(join);
  }
  Effects show(double width) {
    v1::SliceView view;
    view.set_layout(v1::SliceView::FOUR);
    view.set_window_width(width);
    return together.handle(SliceViewSent{presenter, view}, state, now);
  }
  Effects measure(int count) {
    v1::Measurements measurements;
    for (int i = 0; i < count; ++i) measurements.add_items()->add_points()->set_x(i);
    return together.handle(MeasurementsSent{presenter, measurements}, state, now);
  }
  Effects point_in_slice(std::uint64_t from, double x) {
    v1::PointerMove move;
    move.mutable_slice()->set_plane(v1::AXIAL);
    move.mutable_slice()->mutable_place()->set_x(x);
    return together.handle(PointerMoved{from, move}, state, now);
  }
  Effects point_in_picture(std::uint64_t from, double x = 0.5) {
    v1::PointerMove move;
    move.mutable_picture()->set_x(x);
    return together.handle(PointerMoved{from, move}, state, now);
  }
  /// Points at a surface at this x in mm.
  Effects point(std::uint64_t from, double x) {
    const auto asked = sole<FindPointer>(point_in_picture(from));
    return together.handle(PointerFound{from, asked.number, Double3{x, 0, 0}}, state, now);
  }
  static v1::Marks marks(const std::string& text, std::uint32_t count = 1) {
    v1::Marks marks;
    for (std::uint32_t i = 0; i < count; ++i) {
      v1::Mark& mark = *marks.add_items();
      mark.set_id(i + 1);
      mark.set_kind(v1::Mark::TEXT);
      mark.set_text(text);
      mark.mutable_place()->set_x(i);
    }
    return marks;
  }
  Effects mark(std::uint64_t from, const std::string& text, std::uint32_t count = 1) {
    return together.handle(MarksSent{from, marks(text, count)}, state, now);
  }
  Effects take(std::uint64_t connection) {
    const std::uint64_t seq = state.audience.find(connection)->shared.sent;
    return together.handle(SharedReceived{connection, seq}, state, now);
  }
  Effects changed() { return together.handle(ParticipantsChanged{}, state, now); }

  TimePoint now = TimePoint() + seconds(100);
  SessionState state;
  Collaboration together;
  std::uint64_t presenter = 0;
};

TEST_F(CollaborationTest, StoresAndSendsNothingForALoneViewer) {
  EXPECT_TRUE(show(400).empty());
  EXPECT_TRUE(measure(2).empty());
  EXPECT_TRUE(point_in_picture(presenter).empty());
  join("account", ViewerKind::kShared);
  EXPECT_TRUE(changed().empty());
}

TEST_F(CollaborationTest, OnlyFollowersWithSlicesGetThePresentersSlices) {
  for (const ViewerKind viewer : kViewers) {
    for (const bool allowed : {false, true}) {
      SCOPED_TRACE(static_cast<int>(viewer));
      SessionState fresh;
      fresh.requested.scene = state.requested.scene;
      fresh.audience.slices_shown.layout = v1::SliceView::FOUR;
      state = std::move(fresh);
      together = {};
      presenter = greet(owner());
      JoinRequest request;
      request.participant = "other";
      request.viewer = viewer;
      request.may_have_slices = allowed;
      state.audience.guest_slices = allowed;
      const std::uint64_t other = greet(request);
      const bool gets = allowed || viewer == ViewerKind::kOwner;
      EXPECT_EQ(show(400).size(), gets ? 1u : 0u);
      take(other);
      EXPECT_EQ(measure(1).size(), gets ? 1u : 0u);
      take(other);
      const auto pointer = only<Send>(point_in_slice(presenter, 5));
      ASSERT_EQ(pointer.size(), 1u);
      const auto& shown = pointer[0].message.shared().pointers(0);
      EXPECT_EQ(shown.shown(), gets);
      EXPECT_EQ(shown.x(), gets ? 5 : 0);
    }
  }
}

TEST_F(CollaborationTest, SlowFollowerGetsOnlyTheNewestState) {
  const std::uint64_t slow = join("a", ViewerKind::kShared);
  const std::uint64_t fast = join("b", ViewerKind::kShared);
  std::size_t sent_to_slow = 0, sent_to_fast = 0;
  for (int i = 1; i <= 20; ++i) {
    for (const Send& send : only<Send>(show(i)))
      ++(send.connection == slow ? sent_to_slow : sent_to_fast);
    take(fast);
  }
  EXPECT_EQ(sent_to_fast, 20u);
  EXPECT_EQ(sent_to_slow, Collaboration::kMostUnderWay);
  measure(3);
  const auto last = sole<Send>(take(slow));
  EXPECT_EQ(last.connection, slow);
  EXPECT_EQ(last.message.shared().slice_view().window_width(), 20);
  EXPECT_EQ(last.message.shared().measurements().items_size(), 3);
  EXPECT_EQ(last.message.shared().seq(), 3u);
}

TEST_F(CollaborationTest, IgnoresAcknowledgementsOfWhatWasNotSent) {
  const std::uint64_t follower = join("a", ViewerKind::kShared);
  show(1);
  show(2);
  together.handle(SharedReceived{follower, 1000}, state, now);
  EXPECT_TRUE(show(3).empty());
}

TEST_F(CollaborationTest, NewcomersAndNewlyAllowedGuestsGetTheNewestState) {
  join("a", ViewerKind::kShared);
  show(400);
  const std::uint64_t guest = join("guest");
  EXPECT_TRUE(changed().empty());
  state.audience.guest_slices = true;
  const auto sent = sole<Send>(changed());
  EXPECT_EQ(sent.connection, guest);
  EXPECT_EQ(sent.message.shared().slice_view().window_width(), 400);
  take(guest);
  // Switched off and on again, everything is sent again.
  state.audience.guest_slices = false;
  EXPECT_TRUE(changed().empty());
  state.audience.guest_slices = true;
  EXPECT_TRUE(sole<Send>(changed()).message.shared().has_slice_view());
}

TEST_F(CollaborationTest, ClosesTheSlicesOfAPresenterWhoHandsOverToSomeoneWithoutAccess) {
  const std::uint64_t account = join("a", ViewerKind::kShared);
  join("guest");
  show(400);
  take(account);
  state.audience.presenter = "guest";
  const auto sent = only<Send>(changed());
  ASSERT_EQ(sent.size(), 2u);
  for (const Send& send : sent) {
    EXPECT_EQ(send.message.shared().slice_view().layout(), v1::SliceView::LAYOUT_UNSPECIFIED);
  }
}

TEST_F(CollaborationTest, EveryoneElseSeesAPointerOnTheSurface) {
  const std::uint64_t guest = join("guest");
  join("other");
  const auto sent = only<Send>(point(guest, 7));
  ASSERT_EQ(sent.size(), 2u);
  for (const Send& send : sent) {
    EXPECT_NE(send.connection, guest);
    const auto& pointer = send.message.shared().pointers(0);
    EXPECT_EQ(pointer.number(), state.audience.find(guest)->number);
    EXPECT_TRUE(pointer.shown());
    EXPECT_EQ(pointer.x(), 7);
  }
}

TEST_F(CollaborationTest, PointerAtTheBackgroundOrOutsideIsHidden) {
  const std::uint64_t guest = join("guest");
  point(guest, 7);
  take(presenter);
  const auto asked = sole<FindPointer>(point_in_picture(guest));
  const auto sent =
      sole<Send>(together.handle(PointerFound{guest, asked.number, std::nullopt}, state, now));
  EXPECT_FALSE(sent.message.shared().pointers(0).shown());
  take(presenter);
  point(guest, 8);
  take(presenter);
  const auto left = sole<Send>(together.handle(PointerMoved{guest, {}}, state, now));
  EXPECT_FALSE(left.message.shared().pointers(0).shown());
  EXPECT_TRUE(point_in_picture(guest, 1.5).empty());
  EXPECT_TRUE(point_in_picture(guest, std::numeric_limits<double>::quiet_NaN()).empty());
}

TEST_F(CollaborationTest, AnswerToAnEarlierMoveIsIgnored) {
  const std::uint64_t guest = join("guest");
  const auto first = sole<FindPointer>(point_in_picture(guest));
  point_in_picture(guest);
  EXPECT_TRUE(
      together.handle(PointerFound{guest, first.number, Double3{1, 0, 0}}, state, now).empty());
}

TEST_F(CollaborationTest, LimitsMovesPerParticipantAndSurfacesPerSession) {
  const std::uint64_t guest = join("guest");
  int moves = 0;
  for (int i = 0; i < 100; ++i) moves += point_in_picture(guest).empty() ? 0 : 1;
  EXPECT_EQ(moves, Collaboration::kMovesInARow);
  now += milliseconds(1000);
  moves = 0;
  for (int i = 0; i < 100; ++i) moves += point_in_picture(guest).empty() ? 0 : 1;
  EXPECT_EQ(moves, Collaboration::kMovesASecond);
  // Many participants share the surfaces of a session.
  now += seconds(60);
  moves = 0;
  for (int person = 0; person < 10; ++person) {
    const std::uint64_t one = join("guest" + std::to_string(person));
    for (int i = 0; i < 20; ++i) moves += point_in_picture(one).empty() ? 0 : 1;
  }
  EXPECT_EQ(moves, Collaboration::kSurfacesInARow);
}

TEST_F(CollaborationTest, PresenterTurnsOffThePointersOfGuestsOnly) {
  const std::uint64_t guest = join("guest");
  const std::uint64_t account = join("account", ViewerKind::kShared);
  v1::ClientMessage off;
  off.mutable_guest_pointers()->set_on(false);
  EXPECT_TRUE(refused_request(state, guest, off));
  EXPECT_FALSE(refused_request(state, presenter, off));
  EXPECT_TRUE(receive(state, presenter, off, now).audience);
  v1::ClientMessage pointer;
  pointer.mutable_pointer();
  EXPECT_EQ(refused_request(state, guest, pointer)->field(), "pointer");
  EXPECT_FALSE(refused_request(state, account, pointer));
  // A move that was under way is not shown either.
  EXPECT_TRUE(point(guest, 3).empty());
  EXPECT_FALSE(audience_for(state.audience, *state.audience.find(guest)).guest_pointers());
}

TEST_F(CollaborationTest, NewcomersDoNotGetOldPointersOrThoseOfPeopleWhoLeft) {
  const std::uint64_t guest = join("guest");
  point(guest, 3);
  now += Collaboration::kPointerFor + milliseconds(1);
  join("late");
  EXPECT_TRUE(changed().empty());
  point(guest, 4);
  detach(state, guest, now);
  join("later");
  take(presenter);
  for (const Send& send : only<Send>(changed()))
    EXPECT_EQ(send.message.shared().pointers_size(), 0);
}

TEST_F(CollaborationTest, RefusesInvalidViewsAndDropsUnknownFields) {
  join("a", ViewerKind::kShared);
  EXPECT_TRUE(sole<Send>(show(std::numeric_limits<double>::infinity())).message.has_problem());
  EXPECT_TRUE(sole<Send>(measure(scene::kMostMeasurements + 1)).message.has_problem());
  v1::SliceView view;
  view.set_layout(v1::SliceView::FOUR);
  view.GetReflection()->MutableUnknownFields(&view)->AddLengthDelimited(900, "payload");
  const auto sent = sole<Send>(together.handle(SliceViewSent{presenter, view}, state, now));
  EXPECT_EQ(sent.message.SerializeAsString().find("payload"), std::string::npos);
  EXPECT_TRUE(sent.message.shared().has_slice_view());
}

TEST_F(CollaborationTest, ParticipantsHaveUniqueSmallNumbers) {
  const std::uint64_t first = join("a");
  const std::uint64_t second = join("b");
  EXPECT_EQ(state.audience.find(presenter)->number, 0u);
  EXPECT_EQ(state.audience.find(first)->number, 1u);
  EXPECT_EQ(state.audience.find(second)->number, 2u);
  detach(state, first, now);
  EXPECT_EQ(state.audience.find(join("c"))->number, 1u);
}

/// Returns the marks in the only message, which is for this connection, by number.
std::map<std::uint32_t, std::vector<std::string>> marks_in(const Effects& effects,
                                                           std::uint64_t connection) {
  const auto sent = only<Send>(effects);
  std::map<std::uint32_t, std::vector<std::string>> found;
  for (const Send& one : sent) {
    if (one.connection != connection) continue;
    for (const auto& of : one.message.shared().marks()) {
      auto& texts = found[of.number()];
      for (const v1::Mark& mark : of.marks().items()) texts.push_back(mark.text());
    }
  }
  return found;
}
using MarksByNumber = std::map<std::uint32_t, std::vector<std::string>>;

TEST_F(CollaborationTest, EveryoneGetsTheMarksOfTheOthersAlsoWithoutSlices) {
  const std::uint64_t guest = join("guest");
  const std::uint64_t other = join("other", ViewerKind::kShared);
  const Effects sent = mark(presenter, "Here");
  EXPECT_EQ(marks_in(sent, guest), (MarksByNumber{{0, {"Here"}}}));
  EXPECT_EQ(marks_in(sent, other), (MarksByNumber{{0, {"Here"}}}));
  EXPECT_EQ(only<Send>(sent).size(), 2u) << "not to the one who made it";
  EXPECT_EQ(marks_in(mark(guest, "There"), presenter), (MarksByNumber{{1, {"There"}}}));
}

TEST_F(CollaborationTest, NewcomersGetMarksThatWereMadeAlone) {
  EXPECT_TRUE(mark(presenter, "Before").empty());
  const std::uint64_t guest = join("guest");
  EXPECT_EQ(marks_in(changed(), guest), (MarksByNumber{{0, {"Before"}}}));
}

TEST_F(CollaborationTest, MarksOfGuestsVanishWhileThePresenterTurnsThemOff) {
  const std::uint64_t guest = join("guest");
  mark(guest, "Mine");
  take(presenter);
  state.audience.guest_pointers = false;
  EXPECT_EQ(marks_in(changed(), presenter), (MarksByNumber{{1, {}}}));
  EXPECT_TRUE(together.placed_marks().empty());
  take(presenter);
  state.audience.guest_pointers = true;
  EXPECT_EQ(marks_in(changed(), presenter), (MarksByNumber{{1, {"Mine"}}}));
  EXPECT_EQ(together.placed_marks().size(), 1u);
}

TEST_F(CollaborationTest, MarksGoWithTheirParticipant) {
  const std::uint64_t guest = join("guest");
  mark(guest, "Mine");
  detach(state, guest, now);
  changed();
  EXPECT_TRUE(together.placed_marks().empty());
}

TEST_F(CollaborationTest, RefusesInvalidMarksAndCleansTheirTexts) {
  const std::uint64_t guest = join("guest");
  EXPECT_TRUE(sole<Send>(mark(presenter, "a", scene::kMostMarks + 1)).message.has_problem());
  v1::Marks invalid[5] = {marks("a"), marks("a"), marks("a"), marks("a"), marks("a", 2)};
  invalid[0].mutable_items(0)->set_colour(scene::kMarkColours);
  invalid[1].mutable_items(0)->mutable_place()->set_y(std::numeric_limits<double>::quiet_NaN());
  invalid[2].mutable_items(0)->set_radius(-1);
  invalid[3].mutable_items(0)->set_kind(v1::Mark::KIND_UNSPECIFIED);
  invalid[4].mutable_items(1)->set_id(invalid[4].items(0).id());
  for (const v1::Marks& marks : invalid) {
    const auto refused = sole<Send>(together.handle(MarksSent{presenter, marks}, state, now));
    EXPECT_EQ(refused.message.problem().field(), "marks");
  }
  const std::string longest(scene::kLongestMarkText, 'x');
  EXPECT_EQ(marks_in(mark(presenter, "a\n\xe2\x80\xae b"), guest), (MarksByNumber{{0, {"a b"}}}));
  take(guest);
  EXPECT_EQ(marks_in(mark(presenter, longest + "y"), guest), (MarksByNumber{{0, {longest}}}));
}

TEST_F(CollaborationTest, LimitsChangesOfMarksAndQuestionsAboutThem) {
  join("guest");
  int taken = 0, answered = 0;
  for (int i = 0; i < 100; ++i) {
    const Effects effects = mark(presenter, std::to_string(i));
    const auto sent = only<Send>(effects);
    if (sent.empty() || !sent[0].message.has_problem()) ++taken;
    answered += static_cast<int>(together.handle(MarkSightRequested{presenter}, state, now).size());
  }
  EXPECT_EQ(taken, Collaboration::kMarksInARow);
  EXPECT_EQ(answered, Collaboration::kSightsInARow);
}

}  // namespace
}  // namespace diaphane::render
