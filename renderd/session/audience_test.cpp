#include "renderd/session/audience.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr char kAnn[] = "00000000-0000-4000-8000-00000000000a";
constexpr char kBob[] = "00000000-0000-4000-8000-00000000000b";

v1::ClientMessage handover(const std::string& to) {
  v1::ClientMessage message;
  message.mutable_handover()->set_to(to);
  return message;
}

v1::ClientMessage resized(std::uint64_t seq, std::uint32_t width, std::uint32_t height) {
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(seq);
  message.mutable_scene()->mutable_viewport()->set_width(width);
  message.mutable_scene()->mutable_viewport()->set_height(height);
  return message;
}

v1::ClientMessage hello_for(v1::Codec codec) {
  v1::ClientMessage message = hello();
  message.mutable_hello()->clear_codecs();
  message.mutable_hello()->add_codecs(codec);
  return message;
}

struct AudienceTest : testing::Test {
  AudienceTest() {
    state.codecs = {v1::JPEG, v1::H264};
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    state.requested.version = 1;
  }
  std::uint64_t arrive(const std::string& participant, const std::string& name = {}) {
    const auto viewer = participant == kOwner ? ViewerKind::kOwner : ViewerKind::kGuest;
    return attach(state, {participant, name, {}, viewer}, now)->connection;
  }
  std::uint64_t join(const std::string& participant, v1::Codec codec = v1::JPEG) {
    const std::uint64_t connection = arrive(participant);
    EXPECT_FALSE(say(connection, hello_for(codec)).problem);
    return connection;
  }
  Outcome say(std::uint64_t connection, const v1::ClientMessage& message) {
    return receive(state, connection, message, now);
  }
  // Encodes one picture. Returns the sequence number of the frame for each viewer who got it.
  std::map<std::uint64_t, std::uint64_t> show(v1::Codec codec = v1::JPEG) {
    const FrameInfo info = frame(state.epoch, false, state.requested.input_seq);
    const Admitted admitted = admit(state, codec, info, now);
    last_key = admitted.key;
    std::map<std::uint64_t, std::uint64_t> got;
    if (admitted.admission != Admission::kGo) return got;
    last = depart(state, codec, info, {codec == v1::JPEG || admitted.key, 1000}, now);
    for (const OutgoingFrame& one : last.frames) got[one.connection] = one.seq;
    return got;
  }
  void acknowledge(const std::map<std::uint64_t, std::uint64_t>& got, std::uint64_t connection) {
    const auto found = got.find(connection);
    if (found != got.end()) say(connection, ack(found->second));
  }

  SessionState state;
  OutgoingFrames last;
  bool last_key = false;
  TimePoint now = TimePoint{} + std::chrono::hours(1);
};

TEST_F(AudienceTest, SendsOneImageToAllWithIndividualSequenceNumbers) {
  const auto owner = join(std::string(kOwner));
  auto got = show();
  acknowledge(got, owner);
  const auto ann = join(kAnn);
  const auto bob = join(kBob);
  got = show();
  EXPECT_EQ(got, (std::map<std::uint64_t, std::uint64_t>{{owner, 2}, {ann, 1}, {bob, 1}}));
}

TEST_F(AudienceTest, StalledFollowerDoesNotSlowOthers) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  const auto stuck = join(kBob);
  int to_owner = 0, to_ann = 0, to_stuck = 0;
  for (int i = 0; i < 100; ++i) {
    const auto got = show();
    to_owner += static_cast<int>(got.count(owner));
    to_ann += static_cast<int>(got.count(ann));
    to_stuck += static_cast<int>(got.count(stuck));
    acknowledge(got, owner);
    acknowledge(got, ann);
  }
  EXPECT_EQ(to_owner, 100);
  EXPECT_EQ(to_ann, 100);
  EXPECT_EQ(to_stuck, 2);
}

TEST_F(AudienceTest, SendsMissedImageOnlyToTheViewerThatMissedIt) {
  const auto owner = join(std::string(kOwner));
  const auto slow = join(kAnn);
  for (int i = 0; i < 3; ++i) acknowledge(show(), owner);
  state.requested.picture_again = false;
  EXPECT_TRUE(say(slow, ack(2)).room);
  EXPECT_TRUE(state.requested.picture_again) << "nothing else would bring it the last picture";
  // The same picture again.
  FrameInfo same = *state.audience.find(owner)->shown;
  ASSERT_EQ(admit(state, v1::JPEG, same, now).admission, Admission::kGo);
  last = depart(state, v1::JPEG, same, {true, 1000}, now);
  ASSERT_EQ(last.frames.size(), 1U);
  EXPECT_EQ(last.frames[0].connection, slow);
}

TEST_F(AudienceTest, PresenterSetsThePaceUntilTheyStall) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  for (int i = 0; i < 2; ++i) acknowledge(show(), ann);
  EXPECT_TRUE(show().empty()) << "the presenter has no room";
  EXPECT_FALSE(has_room(state, v1::JPEG, now));
  now += kPaceFor;
  EXPECT_TRUE(has_room(state, v1::JPEG, now));
  EXPECT_EQ(show().count(ann), 1U);
  detach(state, owner, now);
  say(ann, ack(3));
  EXPECT_EQ(show().count(ann), 1U) << "without a presenter, any viewer sets the pace";
}

// In inter-coded streams, no viewer gets a frame without its predecessor.
TEST_F(AudienceTest, ViewersJoinInterCodedStreamAtKeyFrames) {
  const auto owner = join(std::string(kOwner), v1::H264);
  auto got = show(v1::H264);
  EXPECT_TRUE(last_key);
  acknowledge(got, owner);
  const auto slow = join(kAnn, v1::H264);
  now += kKeyEvery;
  bool complete = false;  // whether `slow` has every frame since its last key frame
  int keys = 0;
  TimePoint key_at{};
  for (int i = 0; i < 400; ++i) {
    got = show(v1::H264);
    acknowledge(got, owner);
    ASSERT_EQ(got.count(owner), 1U);
    if (last_key) {
      ++keys;
      EXPECT_GE(now - key_at, kKeyEvery);
      key_at = now;
      complete = got.contains(slow);
    }
    ASSERT_TRUE(!got.contains(slow) || complete) << "a frame that cannot be decoded";
    if (!got.contains(slow)) complete = false;
    if (i % 5 == 0) {
      const auto& flight = state.audience.find(slow)->flight;
      if (flight.unacknowledged() > 0) say(slow, ack(state.audience.find(slow)->flight.sent()));
    }
    now += milliseconds(16);
  }
  EXPECT_GT(keys, 3);
  EXPECT_LE(keys, 400 * 16 / 500 + 2);
}

TEST_F(AudienceTest, EachCodecHasItsOwnStream) {
  const auto owner = join(std::string(kOwner), v1::H264);
  const auto ann = join(kAnn, v1::JPEG);
  EXPECT_EQ(show(v1::H264).count(ann), 0U);
  EXPECT_EQ(show(v1::H264).count(owner), 1U);
  EXPECT_TRUE(show(v1::H264).empty()) << "the presenter has no room";
  EXPECT_EQ(show(v1::JPEG).count(ann), 1U) << "but the other stream is not the presenter's";
}

TEST_F(AudienceTest, IgnoresSceneAndCanvasOfFollowers) {
  join(std::string(kOwner));
  const auto ann = join(kAnn);
  const ViewRequest before = state.requested;
  const Outcome refused = say(ann, turned(1));
  ASSERT_TRUE(refused.problem);
  EXPECT_EQ(refused.problem->code(), "forbidden");
  EXPECT_EQ(refused.problem->input_seq(), 1U);
  EXPECT_FALSE(refused.problem->fatal());
  EXPECT_EQ(refused_request(state, ann, turned(3))->input_seq(), 3U);
  EXPECT_FALSE(say(ann, resized(2, 100, 50)).problem);
  EXPECT_EQ(state.requested.version, before.version);
  EXPECT_EQ(state.requested.viewport, before.viewport);
  EXPECT_EQ(state.requested.scene, before.scene);
}

TEST_F(AudienceTest, HandoverTransfersSceneControlAndCanvasSize) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  say(ann, resized(1, 300, 200));
  EXPECT_EQ(say(ann, handover(kAnn)).problem->code(), "forbidden")
      << "a follower cannot take the role";
  EXPECT_EQ(say(owner, handover(kBob)).problem->code(), "not_found");
  const Outcome given = say(owner, handover(kAnn));
  EXPECT_FALSE(given.problem);
  EXPECT_TRUE(given.presenter);
  EXPECT_TRUE(given.audience);
  EXPECT_EQ(state.requested.viewport, (Canvas{300, 200}));
  EXPECT_FALSE(say(ann, turned(2)).problem);
  EXPECT_EQ(state.requested.scene->camera().eye().x(), 2);
  EXPECT_EQ(say(owner, turned(1)).problem->code(), "forbidden");
}

TEST_F(AudienceTest, OwnerTakesTheRoleBackAtAnyTime) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  const auto bob = join(kBob);
  const auto take_back = [&] { return say(owner, handover(std::string(kOwner))); };
  say(owner, handover(kAnn));
  EXPECT_TRUE(say(bob, handover(kBob)).problem) << "Bob is not the owner";
  EXPECT_TRUE(say(owner, handover(kBob)).problem) << "the owner must take it back first";
  EXPECT_FALSE(take_back().problem) << "Ann is still there";
  EXPECT_FALSE(say(owner, turned(1)).problem);
  EXPECT_EQ(say(ann, turned(1)).problem->code(), "forbidden");

  say(owner, handover(kAnn));
  detach(state, ann, now);
  EXPECT_FALSE(take_back().problem) << "Ann has left";
  // The viewer returns as a follower.
  const auto again = join(kAnn);
  EXPECT_EQ(say(again, turned(1)).problem->code(), "forbidden");
}

TEST_F(AudienceTest, SecondConnectionOfAParticipantReplacesOnlyTheFirst) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  const auto attached = attach(state, {kAnn, {}, {}}, now);
  ASSERT_TRUE(attached);
  EXPECT_EQ(attached->replaced, ann);
  EXPECT_TRUE(state.audience.find(owner));
  EXPECT_FALSE(state.audience.find(ann));
  EXPECT_FALSE(say(ann, turned(1)).problem) << "messages of the old connection are ignored";
}

TEST_F(AudienceTest, ResendsEverythingAfterAFreeCamera) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  began(state, 1, state.requested);
  acknowledge(show(), owner);
  show();  // two frames are in transit to Ann
  const Outcome asked = say(ann, [] {
    v1::ClientMessage message;
    message.mutable_free_camera()->set_on(true);
    return message;
  }());
  EXPECT_EQ(asked.free_camera, true);
  use_free_camera(state, *state.audience.find(ann), true, now);
  acknowledge(show(), owner);
  EXPECT_EQ(show().count(ann), 0U) << "the group's frames are not sent to her meanwhile";
  EXPECT_EQ(say(owner, handover(kAnn)).problem->code(), "conflict");
  use_free_camera(state, *state.audience.find(ann), false, now);
  EXPECT_TRUE(state.requested.picture_again);
  say(owner, ack(state.audience.find(owner)->flight.sent()));
  const auto got = show();
  ASSERT_EQ(got.count(ann), 1U);
  EXPECT_EQ(got.at(ann), 1U) << "numbering restarts with the full window of a new viewer";
}

TEST_F(AudienceTest, SendsTheSceneWithItsFirstImageToFollowers) {
  const auto owner = join(std::string(kOwner));
  const auto ann = join(kAnn);
  state.audience.find(ann)->look_version = state.requested.version;
  began(state, 1, state.requested);
  auto got = show();
  for (const OutgoingFrame& one : last.frames) EXPECT_FALSE(one.look);
  say(owner, turned(1));
  began(state, 2, state.requested);
  show();
  ASSERT_EQ(last.frames.size(), 2U);
  for (const OutgoingFrame& one : last.frames) EXPECT_EQ(one.look, one.connection == ann);
  for (const auto viewer : {owner, ann}) {
    say(viewer, ack(state.audience.find(viewer)->flight.sent()));
  }
  show();
  ASSERT_FALSE(last.frames.empty());
  for (const OutgoingFrame& one : last.frames) EXPECT_FALSE(one.look) << "she has it already";
}

TEST_F(AudienceTest, NewViewersHaveNoSlicesUnlessTheyMay) {
  const auto slices = [&](const JoinRequest& request) {
    return state.audience.find(attach(state, request, now)->connection)->may_have_slices;
  };
  JoinRequest request;
  request.participant = kAnn;
  EXPECT_FALSE(slices(request));
  request.may_have_slices = true;
  EXPECT_TRUE(slices(request));
}

TEST_F(AudienceTest, GuestsHaveSlicesWhileThePresenterShowsSome) {
  const auto owner = join(std::string(kOwner)), guest = join(kAnn);
  const auto access = [&](std::uint64_t connection) {
    return slice_access(state.audience.rights(*state.audience.find(connection)));
  };
  v1::ClientMessage allow, open, close;
  allow.mutable_guest_slices()->set_on(true);
  open.mutable_slice_view()->set_layout(v1::SliceView::FOUR);
  close.mutable_slice_view();
  say(owner, open);
  EXPECT_EQ(access(guest), SliceAccess::kNone) << "not allowed by the host";
  say(owner, allow);
  EXPECT_EQ(access(guest), SliceAccess::kShown);
  EXPECT_TRUE(say(owner, close).audience);
  EXPECT_EQ(access(guest), SliceAccess::kNone);
  EXPECT_EQ(access(owner), SliceAccess::kWhole);
  EXPECT_TRUE(say(owner, open).audience);
  EXPECT_FALSE(say(owner, open).audience) << "nothing has changed";
  EXPECT_EQ(access(guest), SliceAccess::kShown);
  state.audience.find(guest)->free_camera = true;
  EXPECT_EQ(access(guest), SliceAccess::kNone) << "they do not follow the presenter";
  state.audience.find(guest)->may_have_slices = true;
  EXPECT_EQ(access(guest), SliceAccess::kClipped) << "their link allows all slices";
  state.audience.find(guest)->may_have_slices = false;
  state.audience.find(guest)->free_camera = false;
  detach(state, owner, now);
  EXPECT_EQ(access(guest), SliceAccess::kNone) << "nobody presents";
  state.audience.presenter = kAnn;
  say(guest, close);
  EXPECT_EQ(access(guest), SliceAccess::kClipped) << "a presenting guest may show some";
}

TEST_F(AudienceTest, LimitsTheNumberOfViewers) {
  static_assert(kMostReceivers == 64, "docs/bounds.md");
  for (std::size_t i = 0; i < kMostReceivers; ++i) arrive("guest " + std::to_string(i));
  const auto refused = attach(state, {"one more", {}, {}}, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooMany);
  EXPECT_TRUE(attach(state, {"guest 3", {}, {}}, now)) << "one who comes back takes no new place";
}

TEST_F(AudienceTest, ParticipantListContainsOnlyNamesAndRoles) {
  const auto owner = join(std::string(kOwner));
  const auto ann = arrive(kAnn,
                          "  Dr.\t\xE2\x80\xAE"
                          "Ann  ");
  say(ann, hello());
  const auto bob = join(kBob);
  const v1::Audience audience = audience_for(state.audience, *state.audience.find(ann));
  EXPECT_EQ(audience.you(), kAnn);
  ASSERT_EQ(audience.participants_size(), 3);
  EXPECT_TRUE(audience.participants(0).owner());
  EXPECT_TRUE(audience.participants(0).presenter());
  EXPECT_EQ(audience.participants(1).name(), "Dr. Ann");
  EXPECT_EQ(audience.participants(2).name(), "Guest 1");
  // The same number after a reconnection.
  detach(state, bob, now);
  join("00000000-0000-4000-8000-00000000000c");
  const auto back = join(kBob);
  EXPECT_EQ(state.audience.find(back)->name, "Guest 1");
  (void)owner;
}

TEST(CleanName, ReturnsShortVisibleText) {
  EXPECT_EQ(clean_name("Ann"), "Ann");
  EXPECT_EQ(clean_name(" \n\tA  B "), "A B");
  EXPECT_EQ(clean_name("J\xC3\xB6rg \xE6\x9D\x8E"), "J\xC3\xB6rg \xE6\x9D\x8E");
  EXPECT_EQ(clean_name(std::string("a\0b\x07"
                                   "c",
                                   5)),
            "abc");
  EXPECT_EQ(clean_name("a\xE2\x80\x8B\xE2\x80\xAE\xEF\xBB\xBF"
                       "b"),
            "ab");
  EXPECT_EQ(clean_name("\xC0\x80\xED\xA0\x80\xFF\xF5\x80\x80\x80"
                       "x\xE2\x82"),
            "x");
  EXPECT_EQ(clean_name(std::string(500, 'a')), std::string(kLongestName, 'a'));
  EXPECT_EQ(clean_name(" \xE2\x80\x8B "), "");
}

v1::ClientMessage hand(bool on, const std::string& of = {}) {
  v1::ClientMessage message;
  message.mutable_raise_hand()->set_on(on);
  message.mutable_raise_hand()->set_of(of);
  return message;
}

TEST_F(AudienceTest, RaisedHandsQueueAndGoDownWhenTheirTurnComes) {
  const std::uint64_t owner = join(std::string(kOwner)), ann = join(kAnn), bob = join(kBob);
  const auto hands = [&] {
    std::map<std::string, std::uint32_t> raised;
    const v1::Audience seen = audience_for(state.audience, *state.audience.find(owner));
    for (const auto& one : seen.participants()) raised[one.id()] = one.hand();
    return std::vector{raised[kAnn], raised[kBob]};
  };
  EXPECT_TRUE(say(bob, hand(true)).audience);
  EXPECT_FALSE(say(bob, hand(true)).audience) << "it is raised already";
  EXPECT_TRUE(say(ann, hand(true)).audience);
  EXPECT_EQ(hands(), (std::vector<std::uint32_t>{2, 1})) << "Bob was first";
  EXPECT_EQ(say(ann, hand(false, kBob)).problem->code(), "forbidden");
  EXPECT_EQ(say(owner, hand(true, kAnn)).problem->code(), "forbidden") << "not for others";
  EXPECT_TRUE(say(owner, hand(false, kBob)).audience);
  EXPECT_EQ(hands(), (std::vector<std::uint32_t>{1, 0}));
  say(owner, handover(kAnn));
  EXPECT_EQ(hands(), (std::vector<std::uint32_t>{0, 0})) << "Ann presents now";
}

}  // namespace
}  // namespace diaphane::render
