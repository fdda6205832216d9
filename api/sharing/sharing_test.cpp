#include "api/sharing/sharing.h"

#include <gmock/gmock.h>

#include "api/shared/secrets.h"
#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_sharing_store.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

class SharingTest : public DataSetFixture {
 protected:
  SharingTest() {
    signals.subscribe(Signal::kMail, [this] { ++woken; });
  }
  Refusal share(const std::string& email) {
    return refusal(sharing.share_with(owner, id, email, false, {true, true}));
  }
  Outcome<Sharing::NewLink> make_link(const IdempotencyScope& once = {},
                                      std::chrono::hours life = 24h,
                                      const Permissions& allowed = {}) {
    return sharing.make_link(owner, id, life, allowed, once);
  }

  FakeSharingStore store;
  const SharingParts parts{data_sets, store, accounts, placement, clock, signals};
  int woken = 0;
  Sharing sharing{parts, {.public_url = "https://see.example"}};
};

TEST_F(SharingTest, OnlyTheOwnerSeesAndChangesWhoHasAccess) {
  const std::string nobody = new_id();
  const auto owns = [&](const Outcome<void>& done) {
    // This error says that there is nothing to withdraw, which only the owner may learn.
    const bool passed = !done && done.error().detail.find("Scan not found") == std::string::npos &&
                        done.error().kind == ProblemKind::kNotFound;
    return passed ? Refusal() : refusal(done);
  };
  expect_permission(Action::kShare,
                    [&](const Principal& who) { return refusal(sharing.people(who, id)); });
  expect_permission(Action::kShare, [&](const Principal& who) {
    return refusal(sharing.share_with(who, id, "friend@example.org", true, {}));
  });
  expect_permission(Action::kShare, [&](const Principal& who) {
    return owns(sharing.change_person(who, id, nobody, {}));
  });
  expect_permission(Action::kShare,
                    [&](const Principal& who) { return owns(sharing.unshare(who, id, nobody)); });
  expect_permission(Action::kShare,
                    [&](const Principal& who) { return refusal(sharing.links(who, id)); });
  expect_permission(Action::kShare, [&](const Principal& who) {
    return refusal(sharing.make_link(who, id, 1h, {}, {}));
  });
  expect_permission(Action::kShare,
                    [&](const Principal& who) { return owns(sharing.end_link(who, id, nobody)); });
}

TEST_F(SharingTest, APersonGetsOneInvitationAndThenTheirPermissionChanges) {
  ASSERT_TRUE(sharing.share_with(owner, id, "Friend@example.org", false, {true, true}));
  ASSERT_TRUE(sharing.share_with(owner, id, "friend@EXAMPLE.org", true, {false, true}));
  EXPECT_EQ(store.invitations.size(), 1u);
  EXPECT_EQ(woken, 1);
  const auto people = sharing.people(owner, id);
  ASSERT_EQ(people->size(), 1u);
  EXPECT_TRUE(is_id(people->at(0).id));
  EXPECT_EQ(people->at(0).email_key, "friend@example.org");
  EXPECT_TRUE(people->at(0).may_save);
  EXPECT_FALSE(people->at(0).allowed.slices);
  EXPECT_TRUE(people->at(0).allowed.downloads);
  EXPECT_EQ(people->at(0).created_at, clock.wall());
  EXPECT_EQ(store.most_people, 50);
}

TEST_F(SharingTest, AnInvitationNamesItsSenderAndNotTheScan) {
  scan().title = "Tumour";
  ASSERT_EQ(share("a@example.org"), Refusal());
  ASSERT_TRUE(sharing.set_public_name(owner, "Anna Bell"));
  ASSERT_EQ(share("b@example.org"), Refusal());
  ASSERT_EQ(store.invitations.size(), 2u);
  EXPECT_EQ(store.invitations[0].recipient, "a@example.org");
  EXPECT_EQ(store.invitations[0].body.find("owner@example.org shared"), 0u);
  EXPECT_EQ(store.invitations[1].body.find("Anna Bell (owner@example.org) shared"), 0u);
  for (const Mail& mail : store.invitations) {
    EXPECT_THAT(mail.subject + mail.body, Not(HasSubstr("Tumour")));
    EXPECT_THAT(mail.body, HasSubstr("https://see.example/scans"));
  }
}

TEST_F(SharingTest, RefusesSharingWithTheOwnerOrAnInvalidAddress) {
  for (const char* bad : {"", "friend", "OWNER@example.org"}) {
    EXPECT_EQ(invalid_field(sharing.share_with(owner, id, bad, false, {})), "email") << bad;
  }
  EXPECT_THAT(store.people_by_key, IsEmpty());
}

TEST_F(SharingTest, LimitsInvitationsToFortyPerDay) {
  for (int i = 0; i < 40; ++i) ASSERT_EQ(share(std::to_string(i) + "@example.org"), Refusal());
  const auto refused = sharing.share_with(owner, id, "friend@example.org", false, {});
  ASSERT_EQ(refusal(refused), ProblemKind::kTooManyAttempts);
  EXPECT_GT(refused.error().retry_after, 0s);
  EXPECT_EQ(store.invitations.size(), 40u);
  clock.advance(24h);
  EXPECT_EQ(share("friend@example.org"), Refusal());
}

TEST_F(SharingTest, AFullListIsReported) {
  store.break_function("share_with", ErrorCode::kTooMany);
  EXPECT_EQ(share("friend@example.org"), ProblemKind::kTooMany);
  EXPECT_EQ(woken, 0);
  store.break_function("make_link", ErrorCode::kTooMany);
  EXPECT_EQ(refusal(make_link()), ProblemKind::kTooMany);
}

TEST_F(SharingTest, LosingSlicesOrDownloadsEndsOnlyTheSessionsOfThatPerson) {
  ASSERT_EQ(share("friend@example.org"), Refusal());
  store.accounts["friend@example.org"] = "friend";
  const std::string person = sharing.people(owner, id)->at(0).id;
  placement.add_session("theirs", "friend", id);
  placement.add_session("elsewhere", "friend", add_scan());
  placement.add_session("shared", shared.user_id, id);
  const auto change = [&](const PersonChange& to) {
    placement.ended.clear();
    EXPECT_TRUE(sharing.change_person(owner, id, person, to));
    return placement.ended;
  };
  EXPECT_THAT(change({.may_save = true}), IsEmpty());
  EXPECT_TRUE(sharing.people(owner, id)->at(0).may_save);
  EXPECT_THAT(change({.slices = false}), ElementsAre("theirs"));
  EXPECT_FALSE(sharing.people(owner, id)->at(0).allowed.slices);
  EXPECT_TRUE(sharing.people(owner, id)->at(0).allowed.downloads);
  placement.add_session("theirs", "friend", id);
  EXPECT_THAT(change({.slices = true}), IsEmpty()) << "more is allowed when they open it again";
  EXPECT_THAT(change({.downloads = false}), ElementsAre("theirs"));
  placement.add_session("theirs", "friend", id);
  placement.ended.clear();
  ASSERT_TRUE(sharing.share_with(owner, id, "friend@example.org", true, {false, false}));
  EXPECT_THAT(placement.ended, ElementsAre("theirs"));
  for (const std::string& none : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(sharing.change_person(owner, id, none, {})), ProblemKind::kNotFound);
  }
}

TEST_F(SharingTest, WithdrawingAccessEndsTheSessionsOfThoseWhoLostItAndNoOthers) {
  ASSERT_EQ(share("friend@example.org"), Refusal());
  const std::string person = sharing.people(owner, id)->at(0).id;
  placement.add_session("lost", "friend", id);
  placement.add_session("owned", owner.user_id, id);
  placement.add_session("shared", shared.user_id, id);
  placement.add_session("elsewhere", "friend", add_scan());
  placement.add_session("visit", "visitor", id);
  store.visits["visit"] = {"visit", id, "link", clock.wall() + 1h};
  placement.add_session("old visit", "visitor", id);
  store.visits["old visit"] = {"old visit", id, "link", clock.wall()};
  for (const std::string& payer : {owner.user_id, shared.user_id}) {
    placement.add_session("study of " + payer, "participant", id);
    placement.sessions["study of " + payer].charged_to = payer;
  }
  ASSERT_TRUE(sharing.unshare(owner, id, person));
  EXPECT_THAT(placement.ended,
              UnorderedElementsAre("lost", "old visit", "study of " + shared.user_id))
      << "a study shows only its researcher's own scans and public ones";
}

TEST_F(SharingTest, WithdrawingAccessToAPublicScanEndsTheSessionsOfThatPerson) {
  ASSERT_EQ(share("friend@example.org"), Refusal());
  store.accounts["friend@example.org"] = "friend";
  expose(Exposure::kPublic);
  placement.add_session("theirs", "friend", id);
  placement.add_session("public", stranger.user_id, id);
  ASSERT_TRUE(sharing.unshare(owner, id, sharing.people(owner, id)->at(0).id));
  EXPECT_THAT(placement.ended, ElementsAre("theirs"));
}

TEST_F(SharingTest, WithdrawingAccessThatWasNotGivenIsNotFound) {
  for (const std::string& none : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(sharing.unshare(owner, id, none)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(sharing.end_link(owner, id, none)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(store.calls("unshare"), 1);
  EXPECT_EQ(store.calls("end_link"), 1);
  EXPECT_EQ(placement.calls("sessions_on"), 0);
}

TEST_F(SharingTest, DatabaseOutageEndsNoSession) {
  placement.add_session("lost", "friend", id);
  data_set_store.break_function("find");
  sharing.end_lost_sessions(id);
  data_set_store.break_function("find", ErrorCode::kOutcomeUnknown);
  sharing.end_lost_sessions(id);
  data_set_store.repair("find");
  store.break_function("find_visit");
  sharing.end_lost_sessions(id);
  store.repair("find_visit");
  placement.break_function("sessions_on");
  sharing.end_lost_sessions(id);
  placement.repair("sessions_on");
  EXPECT_THAT(placement.ended, IsEmpty());
  sharing.end_lost_sessions(id);
  EXPECT_THAT(placement.ended, ElementsAre("lost"));
}

TEST_F(SharingTest, FailureToEndOneSessionDoesNotKeepOthersOpen) {
  placement.add_session("one", "friend", id);
  placement.add_session("two", "friend", id);
  placement.break_function("end");
  sharing.end_lost_sessions(id);
  EXPECT_EQ(placement.calls("end"), 2);
}

TEST_F(SharingTest, LinkIsStoredAsAHashAndExpiresAsRequested) {
  const auto made = make_link({}, 48h, {true, true});
  ASSERT_TRUE(made);
  EXPECT_TRUE(is_token(made->token));
  EXPECT_TRUE(is_id(made->link.id));
  EXPECT_EQ(made->link.created_at, clock.wall());
  EXPECT_EQ(made->link.expires_at, clock.wall() + 48h);
  EXPECT_TRUE(made->link.allowed.slices);
  EXPECT_TRUE(made->link.allowed.downloads);
  ASSERT_EQ(store.all_links.size(), 1u);
  EXPECT_EQ(store.all_links[0].token_hash, blake2b(made->token));
  EXPECT_EQ(store.most_links, 10);
  EXPECT_FALSE(make_link()->link.allowed.slices);
  EXPECT_FALSE(make_link()->link.allowed.downloads);
  clock.advance(48h - 1s);
  EXPECT_EQ(sharing.links(owner, id)->size(), 1u);
  clock.advance(1s);
  EXPECT_THAT(*sharing.links(owner, id), IsEmpty());
}

TEST_F(SharingTest, ARepeatedRequestWithItsKeyReturnsTheSameLinkInTheSameBrowser) {
  const auto first = make_link({"key", "browser"});
  const auto again = make_link({"key", "browser"});
  ASSERT_TRUE(first && again);
  EXPECT_EQ(again->token, first->token);
  EXPECT_EQ(again->link.id, first->link.id);
  EXPECT_NE(make_link({"other key", "browser"})->token, first->token);
  EXPECT_NE(make_link({"", "browser"})->token, first->token);
  EXPECT_EQ(refusal(make_link({"key", "another browser"})), ProblemKind::kConflict);
  ASSERT_TRUE(sharing.end_link(owner, id, first->link.id));
  EXPECT_EQ(refusal(make_link({"key", "browser"})), ProblemKind::kConflict);
}

TEST_F(SharingTest, RefusesAKeyReusedForAnotherScanOrKindOfLink) {
  ASSERT_TRUE(make_link({"key", "browser"}));
  EXPECT_EQ(refusal(make_link({"key", "browser"}, 25h)), ProblemKind::kIdempotencyKeyReused);
  for (const Permissions& other : {Permissions{true, false}, Permissions{false, true}}) {
    EXPECT_EQ(refusal(make_link({"key", "browser"}, 24h, other)),
              ProblemKind::kIdempotencyKeyReused);
  }
  EXPECT_EQ(refusal(sharing.make_link(owner, add_scan(), 24h, {}, {"key", "browser"})),
            ProblemKind::kIdempotencyKeyReused);
}

TEST_F(SharingTest, EndingALinkEndsTheSessionsOfItsVisitors) {
  const std::string ended = make_link()->link.id, kept = make_link()->link.id;
  placement.add_session("by ended", "visitor", id);
  store.visits["by ended"] = {"by ended", id, ended, clock.wall() + 1h};
  placement.add_session("by kept", "visitor", id);
  store.visits["by kept"] = {"by kept", id, kept, clock.wall() + 1h};
  ASSERT_TRUE(sharing.end_link(owner, id, ended));
  EXPECT_THAT(placement.ended, ElementsAre("by ended"));
}

TEST_F(SharingTest, OnlyTheOwnerPublishesAndMakesPrivate) {
  expect_permission(Action::kPublish,
                    [&](const Principal& who) { return refusal(sharing.publish(who, id, {})); });
  expect_permission(Action::kPublish,
                    [&](const Principal& who) { return refusal(sharing.make_private(who, id)); });
}

TEST_F(SharingTest, OnlyAnAnonymisedScanThatIsReadyBecomesPublic) {
  scan().state = DataSetState::kBuilding;
  EXPECT_EQ(refusal(sharing.publish(owner, id, {})), ProblemKind::kNotReady);
  scan().state = DataSetState::kReady;
  store.anonymised = false;
  EXPECT_EQ(refusal(sharing.publish(owner, id, {})), ProblemKind::kNotAnonymised);
  EXPECT_FALSE(store.published);
  store.anonymised = true;
  EXPECT_EQ(sharing.publish(owner, id, {true, false})->id, id);
  EXPECT_TRUE(store.published->slices);
  EXPECT_FALSE(store.published->downloads);
}

TEST_F(SharingTest, WithdrawingSlicesOrDownloadsEndsPublicSessions) {
  expose(Exposure::kPublic);
  placement.add_session("public", stranger.user_id, id);
  placement.add_session("shared", shared.user_id, id);
  placement.add_session("owned", owner.user_id, id);
  ASSERT_TRUE(sharing.publish(owner, id, {true, true}));
  scan().to_public = scan().to_person = {true, true};
  ASSERT_TRUE(sharing.publish(owner, id, {true, true}));
  EXPECT_THAT(placement.ended, IsEmpty());
  ASSERT_TRUE(sharing.publish(owner, id, {false, true}));
  EXPECT_THAT(placement.ended, ElementsAre("public"));
  placement.add_session("public", stranger.user_id, id);
  placement.ended.clear();
  ASSERT_TRUE(sharing.publish(owner, id, {true, false}));
  EXPECT_THAT(placement.ended, ElementsAre("public"));
  placement.ended.clear();
  scan().to_person = {true, false};
  ASSERT_TRUE(sharing.publish(owner, id, {false, true}));
  EXPECT_THAT(placement.ended, IsEmpty()) << "they have the slices by themselves";
  ASSERT_TRUE(sharing.publish(owner, id, {true, false}));
  EXPECT_THAT(placement.ended, ElementsAre("shared")) << "they could save only from the gallery";
}

TEST_F(SharingTest, MakingAScanPrivateEndsSessionsWithWhatOnlyThePublicCouldDo) {
  expose(Exposure::kPublic);
  scan().to_public = {true, false};
  placement.add_session("owned", owner.user_id, id);
  placement.add_session("shared", shared.user_id, id);
  store.before("make_private", [&] { expose(Exposure::kPrivate); });
  ASSERT_TRUE(sharing.make_private(owner, id));
  EXPECT_THAT(placement.ended, ElementsAre("shared"));
}

TEST_F(SharingTest, MakingAScanPrivateEndsThePublicSessions) {
  expose(Exposure::kPublic);
  placement.add_session("public", stranger.user_id, id);
  placement.add_session("shared", shared.user_id, id);
  store.before("make_private", [&] { expose(Exposure::kPrivate); });
  const auto hidden = sharing.make_private(owner, id);
  ASSERT_TRUE(hidden);
  EXPECT_FALSE(hidden->is_public);
  EXPECT_THAT(placement.ended, ElementsAre("public"));
}

TEST_F(SharingTest, WithoutAnAccountTheGalleryHasOnlySamples) {
  Principal sample_operator;
  sample_operator.sample_operator = true;
  for (const auto& [who, samples_only] : {std::pair(Principal{}, true), std::pair(stranger, false),
                                          std::pair(sample_operator, false)}) {
    ASSERT_TRUE(sharing.gallery(who, {.words = "head", .limit = 5}));
    EXPECT_EQ(store.query.samples_only, samples_only) << who.user_id;
    EXPECT_EQ(store.query.words, "head");
  }
}

TEST_F(SharingTest, APageOfTheGalleryEndsWithACursorOnlyIfThereIsMore) {
  for (int i = 0; i < 3; ++i) {
    DataSet one;
    one.id = new_id();
    one.created_at = clock.wall() - 48h;
    if (i != 1) one.published_at = clock.wall();
    store.shown.push_back(one);
  }
  EXPECT_FALSE(sharing.gallery(stranger, {.limit = 3})->next);
  const auto microseconds = [](Time at) { return at.time_since_epoch() / 1us; };
  const auto two = sharing.gallery(stranger, {.limit = 2});
  EXPECT_EQ(two->items.size(), 2u);
  EXPECT_EQ(two->next, (Cursor{microseconds(clock.wall() - 48h), store.shown[1].id}));
  const auto one = sharing.gallery(stranger, {.limit = 1});
  EXPECT_EQ(one->next, (Cursor{microseconds(clock.wall()), store.shown[0].id}));
}

TEST_F(SharingTest, RefusesMisleadingPublicNames) {
  for (const char* bad : {"see.example", "Anna (administrator)", "a@b", "\"Anna\""}) {
    EXPECT_EQ(invalid_field(sharing.set_public_name(owner, bad)), "public_name") << bad;
  }
  EXPECT_EQ(sharing.public_name(owner).value(), "");
  ASSERT_TRUE(sharing.set_public_name(owner, "Dr. Anna O'Bell"));
  EXPECT_EQ(sharing.public_name(owner).value(), "Dr. Anna O'Bell");
}

TEST_F(SharingTest, ReportsAnUnavailableStore) {
  const auto share_again = [&] { return share("friend@example.org"); };
  const auto publish = [&] { return refusal(sharing.publish(owner, id, {})); };
  const auto make_private = [&] { return refusal(sharing.make_private(owner, id)); };
  expect_unavailable({
      {data_set_store, "find", share_again},
      {accounts, "note_attempt", share_again},
      {store, "public_name", share_again},
      {store, "share_with", share_again},
      {store, "people", [&] { return refusal(sharing.people(owner, id)); }},
      {store, "change_person",
       [&] { return refusal(sharing.change_person(owner, id, new_id(), {})); }},
      {store, "unshare", [&] { return refusal(sharing.unshare(owner, id, new_id())); }},
      {store, "links", [&] { return refusal(sharing.links(owner, id)); }},
      {store, "make_link", [&] { return refusal(make_link()); }},
      {store, "end_link", [&] { return refusal(sharing.end_link(owner, id, new_id())); }},
      {data_set_store, "find", publish},
      {store, "publish", publish},
      {data_set_store, "find", make_private},
      {store, "make_private", make_private},
      {store, "gallery", [&] { return refusal(sharing.gallery(owner, {.limit = 1})); }},
      {store, "public_name", [&] { return refusal(sharing.public_name(owner)); }},
      {store, "set_public_name", [&] { return refusal(sharing.set_public_name(owner, "Anna")); }},
  });
}

class VisitsTest : public DataSetFixture {
 protected:
  VisitsTest() { link = add_link(24h); }
  /// Returns the token of a new link to the scan.
  std::string add_link(std::chrono::hours life, const Permissions& allowed = {}) {
    const std::string token = random_hex(32);
    store.all_links.push_back(
        {{new_id(), clock.wall(), clock.wall() + life, allowed}, id, blake2b(token)});
    return token;
  }
  Outcome<Visits::Opened> open(const std::string& key = "key",
                               const std::string& from = "1.2.3.4") {
    return visits.open(link, "", key, {from, "Firefox on Windows"});
  }
  Outcome<Visits::Opened> open_sample(const std::string& key = "key") {
    return visits.open("", id, key, {"1.2.3.4", ""});
  }

  FakeSharingStore store;
  std::string link;
  Visits visits{{data_sets, store, accounts, placement, clock, signals},
                {},
                [](const std::string& data_set_id) { return "scene of " + data_set_id; }};
};

TEST_F(VisitsTest, ALinkIsFollowedUntilItExpiresOrEnds) {
  EXPECT_EQ(visits.follow(link)->data_set.id, id);
  EXPECT_EQ(refusal(visits.follow("no token")), ProblemKind::kNotFound);
  EXPECT_EQ(store.calls("follow"), 1);
  EXPECT_EQ(refusal(visits.follow(random_hex(32))), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(visits.open(random_hex(32), "", "key", {"1.2.3.4", ""})),
            ProblemKind::kNotFound);
  clock.advance(24h);
  EXPECT_EQ(refusal(visits.follow(link)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(open()), ProblemKind::kNotFound);
  EXPECT_THAT(placement.requests, IsEmpty());
}

TEST_F(VisitsTest, AVisitorWithALinkGetsASessionWithinTheVisitorsShare) {
  const auto opened = open();
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->stream_url, "/stream?ticket=ticket1");
  const PlaceRequest& request = placement.requests.at(0);
  EXPECT_EQ(request.session_id, opened->session_id);
  EXPECT_EQ(request.data_set_id, id);
  EXPECT_TRUE(is_id(request.user_id));
  EXPECT_EQ(request.first_scene, "scene of " + id);
  EXPECT_EQ(request.viewer, SessionViewer::kLinkVisitor);
  EXPECT_TRUE(request.visitor);
  EXPECT_EQ(request.visitor_from, blake2b("visit:1.2.3.4")) << "no address is kept";
  EXPECT_FALSE(request.slices);
  EXPECT_FALSE(request.downloads);
  EXPECT_EQ(store.visit_limits.most, 256);
  EXPECT_EQ(store.visit_limits.by_address, 16);
  EXPECT_EQ(store.visit_limits.by_link, 32);
}

TEST_F(VisitsTest, TheOwnerSeesWhichLinkWasUsed) {
  const auto opened = open();
  ASSERT_TRUE(opened);
  ASSERT_EQ(data_set_store.noted_views.size(), 1u);
  const View& view = data_set_store.noted_views[0];
  EXPECT_EQ(view.route, ViewRoute::kLink);
  EXPECT_EQ(view.viewer, opened->session_id);
  EXPECT_EQ(view.link_id, store.all_links.at(0).link.id);
  EXPECT_EQ(view.client.browser, "Firefox on Windows");
  expose(Exposure::kSample);
  ASSERT_TRUE(open_sample());
  EXPECT_EQ(data_set_store.noted_views.size(), 1u) << "nobody owns a sample";
}

TEST_F(VisitsTest, ASampleIsOpenToEverybodyWithItsExactSlices) {
  for (const Exposure exposure :
       {Exposure::kPrivate, Exposure::kPublic, Exposure::kSample, Exposure::kTakenDown}) {
    expose(exposure);
    EXPECT_EQ(refusal(open_sample()),
              exposure == Exposure::kSample ? Refusal() : ProblemKind::kNotFound);
  }
  ASSERT_EQ(placement.requests.size(), 1u);
  EXPECT_EQ(placement.requests[0].viewer, SessionViewer::kSampleVisitor);
  EXPECT_TRUE(placement.requests[0].slices);
  expose(Exposure::kSample);
  scan().state = DataSetState::kQueued;
  EXPECT_EQ(refusal(open_sample()), ProblemKind::kNotReady);
}

TEST_F(VisitsTest, LinkGivesSlicesAndDownloadsOnlyIfAllowed) {
  for (const Permissions& allowed : {Permissions{true, false}, Permissions{false, true}}) {
    link = add_link(1h, allowed);
    ASSERT_TRUE(open());
    EXPECT_EQ(placement.requests.back().slices, allowed.slices);
    EXPECT_EQ(placement.requests.back().downloads, allowed.downloads);
  }
}

TEST_F(VisitsTest, AVisitEndsAfterTwoHoursOrWithItsLinkAndOfASampleAfterTwentyMinutes) {
  EXPECT_EQ(open()->expires_at, clock.wall() + 2h);
  link = add_link(1h);
  EXPECT_EQ(open()->expires_at, clock.wall() + 1h);
  expose(Exposure::kSample);
  EXPECT_EQ(open_sample()->expires_at, clock.wall() + 20min);
}

TEST_F(VisitsTest, SameKeyReturnsTheSameVisitWithoutExtendingIt) {
  const auto first = open();
  clock.advance(1h);
  const auto again = open();
  ASSERT_TRUE(first && again);
  EXPECT_EQ(again->session_id, first->session_id);
  EXPECT_EQ(again->expires_at, first->expires_at);
  EXPECT_NE(again->stream_url, first->stream_url);
  EXPECT_NE(open("other key")->session_id, first->session_id);
  link = add_link(24h);
  const auto by_other_link = open();
  EXPECT_NE(by_other_link->session_id, first->session_id);
  EXPECT_EQ(placement.requests.front().user_id, placement.requests.back().user_id)
      << "it is the same visitor";
}

TEST_F(VisitsTest, LimitsNewVisitsPerAddressToThirtyPerQuarterHour) {
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(open(std::to_string(i)));
  const auto refused = open("another");
  ASSERT_EQ(refusal(refused), ProblemKind::kTooManyAttempts);
  EXPECT_GT(refused.error().retry_after, 0s);
  EXPECT_TRUE(open("0"));
  EXPECT_TRUE(open("another", "5.6.7.8"));
  clock.advance(15min);
  EXPECT_TRUE(open("one more"));
}

TEST_F(VisitsTest, ReportsWhichVisitLimitIsReached) {
  store.break_function("note_visit", ErrorCode::kTooMany, "address");
  const auto from_here = open();
  ASSERT_EQ(refusal(from_here), ProblemKind::kTooManyAttempts);
  EXPECT_EQ(from_here.error().retry_after, 5min);
  for (const char* limit : {"link", ""}) {
    store.break_function("note_visit", ErrorCode::kTooMany, limit);
    const auto refused = open();
    ASSERT_EQ(refusal(refused), ProblemKind::kBusy) << limit;
    EXPECT_EQ(refused.error().retry_after, 30s);
  }
  EXPECT_THAT(placement.requests, IsEmpty());
}

TEST_F(VisitsTest, VisitWithoutASlotIsDeleted) {
  for (const auto& [code, kind] : {std::pair(ErrorCode::kTooLarge, ProblemKind::kBusy),
                                   std::pair(ErrorCode::kUnavailable, ProblemKind::kNoWorker)}) {
    placement.break_function("place", code);
    EXPECT_EQ(refusal(open()), kind);
    EXPECT_THAT(store.visits, IsEmpty());
  }
}

TEST_F(VisitsTest, TryingAgainWithoutASlotIsASingleAttempt) {
  for (int i = 0; i < 31; ++i) {
    placement.break_function("place", ErrorCode::kUnavailable);
    ASSERT_EQ(refusal(open()), ProblemKind::kNoWorker) << i;
    clock.advance(2s);
  }
  placement.repair("place");
  EXPECT_TRUE(open());
}

TEST_F(VisitsTest, RedisOutageIsNotReportedAsMissingCapacity) {
  placement.is_reachable = false;
  placement.break_function("place");
  EXPECT_EQ(refusal(open()), ProblemKind::kUnavailable);
  EXPECT_EQ(store.visits.size(), 1u) << "the session may exist";
  placement.break_function("place", ErrorCode::kNotFound);
  EXPECT_EQ(refusal(open()), ProblemKind::kNotFound);
}

TEST_F(VisitsTest, AVisitEndsIfItsLinkEndedWhileItWasPlaced) {
  placement.before("place", [&] { store.visits.clear(); });
  EXPECT_EQ(refusal(open()), ProblemKind::kNotFound);
  EXPECT_THAT(placement.ended, ElementsAre(placement.requests.at(0).session_id));
}

TEST_F(VisitsTest, UnconfirmedVisitEndsWithoutReportingAnInvalidLink) {
  placement.before("place", [&] { store.break_function("find_visit"); });
  EXPECT_EQ(refusal(open()), ProblemKind::kUnavailable);
  EXPECT_THAT(placement.ended, ElementsAre(placement.requests.at(0).session_id));
}

TEST_F(VisitsTest, AnExpiredVisitEndsAndIsForgottenOnceItHasEnded) {
  const std::string session = open()->session_id;
  visits.expire();
  EXPECT_THAT(placement.ended, IsEmpty());
  clock.advance(2h);
  placement.break_function("end");
  visits.expire();
  EXPECT_EQ(store.visits.size(), 1u) << "it is tried again";
  placement.repair("end");
  visits.expire();
  EXPECT_THAT(placement.ended, ElementsAre(session));
  EXPECT_THAT(store.visits, IsEmpty());
  EXPECT_EQ(store.calls("expire_links"), 3);
  store.break_function("expired_visits");
  visits.expire();
  EXPECT_EQ(placement.calls("end"), 2);
}

TEST_F(VisitsTest, ReportsAnUnavailableStore) {
  expose(Exposure::kSample);
  expect_unavailable({
      {store, "follow", [&] { return refusal(visits.follow(link)); }},
      {store, "follow", [&] { return refusal(open()); }},
      {data_set_store, "find", [&] { return refusal(open_sample()); }},
      {store, "find_visit", [&] { return refusal(open()); }},
      {accounts, "note_attempt", [&] { return refusal(open()); }},
      {store, "note_visit", [&] { return refusal(open()); }},
  });
}

}  // namespace
}  // namespace diaphane::api
