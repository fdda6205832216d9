#include "api/sharing/live_links.h"

#include <gmock/gmock.h>

#include "api/shared/secrets.h"
#include "tests/support/api/data_set_fixture.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// Links in memory, with a record of sessions whose links were disabled.
class FakeLinkStore final : public LinkStore, public Fake {
 public:
  std::map<std::string, Target> links;  ///< by hash
  std::vector<std::string> ended;       ///< sessions

  Result<void> make(std::string_view session_id, std::string_view user_id, std::string_view hash,
                    bool slices) override {
    DIAPHANE_TRY(enter("make"));
    links[std::string(hash)] = {
        {std::string(session_id), std::string(user_id), data_set_id, "", "", over}, slices};
    return {};
  }
  Result<Target> follow(std::string_view hash) override {
    DIAPHANE_TRY(enter("follow"));
    const auto found = links.find(std::string(hash));
    if (found == links.end()) return fail(ErrorCode::kNotFound, "no link");
    return found->second;
  }
  Result<void> end_links(std::string_view session_id) override {
    DIAPHANE_TRY(enter("end_links"));
    std::erase_if(links, [&](const auto& one) { return one.second.session.id == session_id; });
    ended.emplace_back(session_id);
    return {};
  }

  std::string data_set_id, over;
};

class LiveLinksTest : public DataSetFixture {
 protected:
  LiveLinksTest() {
    placement.add_session(session, owner.user_id, id);
    links.data_set_id = id;
  }
  std::string make_link() { return live.make(owner, session, false, {}).value(); }
  Outcome<LiveLinks::Joined> join(const std::string& token, const std::string& key = "key",
                                  const std::string& from = "1.2.3.4") {
    return live.join(token, key, "Bert", {from, "Firefox on Windows"});
  }

  const std::string session = new_id();
  FakeLinkStore links;
  LiveLinks live{data_sets, placement, links, accounts, clock, {}};
};

TEST_F(LiveLinksTest, ALinkIsStoredAsTheHashOfItsToken) {
  const std::string token = make_link();
  EXPECT_TRUE(is_token(token));
  ASSERT_EQ(links.links.size(), 1u);
  const auto& [hash, made] = *links.links.begin();
  EXPECT_EQ(hash, blake2b(token));
  EXPECT_EQ(made.session.id, session);
  EXPECT_EQ(made.session.user_id, owner.user_id);
  EXPECT_FALSE(made.slices);
  EXPECT_NE(make_link(), token);
}

TEST_F(LiveLinksTest, SameKeyInTheSameBrowserReturnsTheSameLink) {
  const auto make = [&](const std::string& of, const std::string& key, const std::string& browser) {
    return live.make(owner, of, false, {key, browser}).value();
  };
  const std::string token = make(session, "key", "browser");
  EXPECT_EQ(make(session, "key", "browser"), token);
  EXPECT_NE(make(session, "key", "another browser"), token);
  EXPECT_NE(make(session, "other key", "browser"), token);
  const std::string other = new_id();
  placement.add_session(other, owner.user_id, id);
  EXPECT_NE(make(other, "key", "browser"), token);
}

TEST_F(LiveLinksTest, OnlyThoseWhoMayInviteMakeLinksToTheirSessions) {
  expect_permission(Action::kInvite, [&](const Principal& who) {
    placement.add_session(session, who.user_id, id);
    return refusal(live.make(who, session, false, {}));
  });
}

TEST_F(LiveLinksTest, SessionsOfOthersAreNotFound) {
  const std::string token = make_link();
  for (const Principal& who : {shared, stranger, administrator}) {
    EXPECT_EQ(refusal(live.make(who, session, false, {})), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(live.end(who, session)), ProblemKind::kNotFound);
  }
  for (const std::string& none : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(live.make(owner, none, false, {})), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(live.end(owner, none)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(links.links.size(), 1u);
  EXPECT_THAT(links.ended, IsEmpty());
}

TEST_F(LiveLinksTest, EachFailureToCreateALinkHasItsOwnError) {
  for (const auto& [code, kind] :
       {std::pair(ErrorCode::kNotFound, ProblemKind::kNotFound),
        std::pair(ErrorCode::kConflict, ProblemKind::kConflict),
        std::pair(ErrorCode::kInvalid, ProblemKind::kIdempotencyKeyReused),
        std::pair(ErrorCode::kTooMany, ProblemKind::kTooMany)}) {
    links.break_function("make", code);
    EXPECT_EQ(refusal(live.make(owner, session, false, {})), kind);
  }
}

TEST_F(LiveLinksTest, EndedLinkCannotBeJoined) {
  const std::string token = make_link();
  ASSERT_TRUE(join(token));
  ASSERT_TRUE(live.end(owner, session));
  EXPECT_THAT(links.ended, ElementsAre(session));
  EXPECT_EQ(refusal(join(token)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(join(random_hex(32))), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(join("no token")), ProblemKind::kNotFound);
  EXPECT_EQ(links.calls("follow"), 3);
}

TEST_F(LiveLinksTest, AGuestJoinsTheSessionOfItsOwnerWithinTheVisitorsShare) {
  const std::string token = make_link();
  const auto joined = join(token);
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->stream_url, "/stream?ticket=ticket1");
  const PlaceRequest& request = placement.requests.at(0);
  EXPECT_EQ(request.session_id, session);
  EXPECT_EQ(request.user_id, owner.user_id);
  EXPECT_EQ(request.data_set_id, id);
  EXPECT_EQ(request.participant, joined->participant);
  EXPECT_EQ(request.name, "Bert");
  EXPECT_EQ(request.link, blake2b(token));
  EXPECT_EQ(request.viewer, SessionViewer::kGuest);
  EXPECT_TRUE(request.visitor);
  EXPECT_EQ(request.visitor_from, blake2b(token));
  EXPECT_FALSE(request.slices);
}

TEST_F(LiveLinksTest, EachLinkHasItsOwnPermissionAndNoMoreThanItsHost) {
  const std::string narrow = make_link();
  const std::string wide = live.make(owner, session, true, {}).value();
  const auto slices = [&](const std::string& token) {
    EXPECT_TRUE(join(token));
    return placement.requests.back().slices;
  };
  EXPECT_FALSE(slices(narrow));
  EXPECT_TRUE(slices(wide));
  EXPECT_FALSE(slices(narrow));

  expose(Exposure::kPublic);
  const std::string hosted = new_id();
  placement.add_session(hosted, stranger.user_id, id);
  EXPECT_EQ(invalid_field(live.make(stranger, hosted, true, {})), "slices");
  scan().to_public.slices = true;
  const std::string of_stranger = live.make(stranger, hosted, true, {}).value();
  EXPECT_TRUE(slices(of_stranger));
  scan().to_public.slices = false;
  EXPECT_FALSE(slices(of_stranger)) << "the owner has withdrawn the slices";
}

TEST_F(LiveLinksTest, TheOwnerSeesThatAGuestJoined) {
  const auto joined = join(make_link());
  ASSERT_TRUE(joined);
  ASSERT_EQ(data_set_store.noted_views.size(), 1u);
  const View& view = data_set_store.noted_views[0];
  EXPECT_EQ(view.route, ViewRoute::kLiveLink);
  EXPECT_EQ(view.viewer, joined->participant);
  EXPECT_EQ(view.client.address, "1.2.3.4");
  const std::string token = make_link();
  data_set_store.break_function("note_view");
  EXPECT_EQ(refusal(join(token)), ProblemKind::kUnavailable);
  expose(Exposure::kSample);
  EXPECT_TRUE(join(token)) << "nobody owns a sample";
}

TEST_F(LiveLinksTest, ReturningGuestIsTheSameParticipant) {
  const std::string token = make_link(), other_link = make_link();
  const std::string participant = join(token)->participant;
  EXPECT_TRUE(is_id(participant));
  EXPECT_EQ(join(token)->participant, participant);
  EXPECT_EQ(join(other_link)->participant, participant);
  EXPECT_NE(join(token, "other key")->participant, participant);
  const std::string other = new_id();
  placement.add_session(other, owner.user_id, id);
  EXPECT_NE(join(live.make(owner, other, false, {}).value())->participant, participant)
      << "sessions cannot be related by their guests";
}

TEST_F(LiveLinksTest, LimitsJoinsPerAddressTo240PerQuarterHour) {
  const std::string token = make_link();
  for (int i = 0; i < 240; ++i) ASSERT_TRUE(join(token));
  const auto refused = join(token);
  ASSERT_EQ(refusal(refused), ProblemKind::kTooManyAttempts);
  EXPECT_GT(refused.error().retry_after, 0s);
  EXPECT_TRUE(join(token, "key", "5.6.7.8"));
  clock.advance(15min);
  EXPECT_TRUE(join(token));
}

TEST_F(LiveLinksTest, LimitsJoinsPerLinkTo960PerQuarterHour) {
  const std::string token = make_link(), other = make_link();
  for (int i = 0; i < 960; ++i) ASSERT_TRUE(join(token, "key", std::to_string(i % 8)));
  EXPECT_EQ(refusal(join(token, "key", "another address")), ProblemKind::kTooManyAttempts);
  EXPECT_TRUE(join(other, "key", "another address"));
}

TEST_F(LiveLinksTest, LinkEndsWhenTheOwnerLosesAccessToTheScan) {
  expose(Exposure::kPublic);
  placement.add_session(session, stranger.user_id, id);
  const std::string token = live.make(stranger, session, false, {}).value();
  ASSERT_TRUE(join(token));
  expose(Exposure::kPrivate);
  EXPECT_EQ(refusal(join(token)), ProblemKind::kNotFound);
  expose(Exposure::kPublic);
  scan().state = DataSetState::kQueued;
  EXPECT_EQ(refusal(join(token)), ProblemKind::kNotFound);
  EXPECT_EQ(placement.requests.size(), 1u);
}

TEST_F(LiveLinksTest, EachPlacementFailureHasItsOwnError) {
  const std::string token = make_link();
  for (const auto& [code, kind, wait] :
       {std::tuple(ErrorCode::kTooLarge, ProblemKind::kBusy, 30s),
        std::tuple(ErrorCode::kNotFound, ProblemKind::kNotFound, 0s),
        std::tuple(ErrorCode::kUnavailable, ProblemKind::kNoWorker, 2s),
        std::tuple(ErrorCode::kTooMany, ProblemKind::kTooMany, 10s)}) {
    placement.break_function("place", code);
    const auto refused = join(token);
    ASSERT_EQ(refusal(refused), kind);
    EXPECT_EQ(refused.error().retry_after, wait);
  }
  placement.break_function("place");
  placement.is_reachable = false;
  EXPECT_EQ(refusal(join(token)), ProblemKind::kUnavailable);
}

TEST_F(LiveLinksTest, ReportsAnUnavailableStore) {
  const std::string token = make_link();
  const auto make = [&] { return refusal(live.make(owner, session, false, {})); };
  const auto end = [&] { return refusal(live.end(owner, session)); };
  expect_unavailable({
      {placement, "find", make},
      {data_set_store, "find", make},
      {links, "make", make},
      {placement, "find", end},
      {links, "end_links", end},
      {links, "follow", [&] { return refusal(join(token)); }},
      {accounts, "note_attempt", [&] { return refusal(join(token)); }},
      {data_set_store, "find", [&] { return refusal(join(token)); }},
  });
}

TEST_F(LiveLinksTest, GuestsSeeTwoScansOnlyIfTheirHostMayInviteToBoth) {
  const std::string other = add_scan();
  placement.sessions[session].over = other;
  links.over = other;
  const std::string token = make_link();
  ASSERT_TRUE(join(token));
  EXPECT_EQ(data_set_store.noted_views.size(), 2u) << "both scans were viewed";
  // A host with whom the second scan is shared must not share it further.
  data_set_store.roles[{"owner", other}] = Role::kSharedView;
  EXPECT_EQ(refusal(live.make(owner, session, false, {})), ProblemKind::kForbidden);
  data_set_store.roles.erase({"owner", other});
  EXPECT_EQ(refusal(live.make(owner, session, false, {})), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(join(token)), ProblemKind::kNotFound) << "the host has lost the second scan";
}

}  // namespace
}  // namespace diaphane::api
