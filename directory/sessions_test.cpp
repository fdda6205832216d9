#include "directory/sessions.h"

#include <gmock/gmock.h>

#include <atomic>
#include <set>
#include <thread>

#include "directory/links.h"
#include "tests/support/directory/test_sessions.h"

namespace diaphane::directory {
namespace {

using testing::ElementsAre;

TEST_F(SessionsTest, FailedPlacementLeavesOnlyTheRefusalCount) {
  const auto asked = request();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(sessions_.place(asked).error().code, ErrorCode::kUnavailable);
  }
  EXPECT_EQ(client_->command({"DBSIZE"})->integer, 1);
  EXPECT_EQ(client_->command({"ZCARD", "diaphane:refused"})->integer, 1);
}

TEST_F(SessionsTest, PrefersWorkerWithTheVolumeThenTheLeastUsed) {
  const std::string volume = new_id();
  announce({.id = "busy", .slots = 4, .volumes = new_id() + "," + volume});
  announce({.id = "idle", .slots = 4});
  EXPECT_EQ(sessions_.place(request(new_id(), volume))->worker_id, "busy");
  EXPECT_EQ(sessions_.place(request(new_id(), volume))->worker_id, "busy");
  EXPECT_EQ(sessions_.place(request())->worker_id, "idle");
  EXPECT_EQ(sessions_.place(request())->worker_id, "idle");
  EXPECT_EQ(used("busy"), 2);
  EXPECT_EQ(used("idle"), 2);
}

TEST_F(SessionsTest, PrefersLowerLoadAtEqualUse) {
  announce({.id = "a", .load = "0.9"});
  announce({.id = "b", .load = "0.1"});
  EXPECT_EQ(sessions_.place(request())->worker_id, "b");
}

TEST_F(SessionsTest, PrefersWorkerWithLowerExpectedLoadOverFewerSessions) {
  announce({.id = "few", .expected = "0"});
  ASSERT_TRUE(sessions_.place(request()));
  announce({.id = "many", .expected = "0"});
  ASSERT_TRUE(sessions_.place(request()));
  announce({.id = "few", .draining = "1"});
  ASSERT_TRUE(sessions_.place(request()));
  ASSERT_EQ(used("few"), 1);
  ASSERT_EQ(used("many"), 2);
  announce(
      {.id = "few", .load = "0.1", .expected = "0.8"});  // the current load alone would favour it
  announce({.id = "many", .load = "0.9", .expected = "0.1"});
  EXPECT_EQ(sessions_.place(request())->worker_id, "many");
}

TEST_F(SessionsTest, CountsSessionsSinceLastHeartbeatWithOneSlotShareEach) {
  announce({.id = "a", .slots = 10, .expected = "0.45"});
  announce({.id = "b", .slots = 10, .expected = "0.5"});
  EXPECT_EQ(sessions_.place(request())->worker_id, "a");
  EXPECT_EQ(sessions_.place(request())->worker_id, "b");  // 0.55 against 0.5, with a
  EXPECT_EQ(sessions_.place(request())->worker_id, "a");  // 0.55 against 0.6, with b
  announce({.id = "a", .slots = 10, .expected = "0.5"});  // the heartbeat includes both sessions
  EXPECT_EQ(sessions_.place(request())->worker_id, "a");
}

TEST_F(SessionsTest, LoadedVolumeOutweighsAQuarterOfADevice) {
  const std::string volume = new_id();
  announce({.id = "with", .slots = 16, .volumes = volume, .expected = "0.6"});
  announce({.id = "without", .slots = 16, .expected = "0.4"});
  EXPECT_EQ(sessions_.place(request(new_id(), volume))->worker_id, "with");
  announce({.id = "with", .slots = 16, .volumes = volume, .expected = "0.7"});
  EXPECT_EQ(sessions_.place(request(new_id(), volume))->worker_id, "without");
}

TEST_F(SessionsTest, NeverChoosesDrainingIncompatibleOrVanishedWorker) {
  announce({.id = "draining", .draining = "1"});
  announce({.id = "older", .epoch = "0"});
  announce({.id = "vanished"});
  vanish("vanished");
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable);
  announce({.id = "good", .slots = 1});
  EXPECT_EQ(sessions_.place(request())->worker_id, "good");
}

TEST_F(SessionsTest, ListsLiveWorkersWithTheirReports) {
  announce({.id = "a", .slots = 3, .volumes = "x,y", .draining = "1"});
  announce({.id = "older", .epoch = "0"});
  announce({.id = "vanished"});
  vanish("vanished");
  const auto alive = sessions_.alive();
  ASSERT_TRUE(alive);
  ASSERT_EQ(alive->size(), 1u);
  EXPECT_EQ((*alive)[0].address, "a:8085");
  EXPECT_EQ((*alive)[0].slots, 3u);
  EXPECT_TRUE((*alive)[0].draining);
  EXPECT_THAT((*alive)[0].volumes, ElementsAre("x", "y"));
}

TEST_F(SessionsTest, ConcurrentPlacementNeverOvercommits) {
  announce({.id = "a", .slots = 37});
  announce({.id = "b", .slots = 23});
  std::atomic<int> placed = 0, refused = 0, wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 20; ++i) {
          const auto result = sessions_.place({new_id(), new_id(), new_id()});
          if (result) {
            ++placed;
          } else {
            ++(result.error().code == ErrorCode::kUnavailable ? refused : wrong);
          }
        }
      });
    }
  }
  EXPECT_EQ(placed, 60);
  EXPECT_EQ(refused, 100);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(used("a"), 37);
  EXPECT_EQ(used("b"), 23);
}

PlaceRequest visit(const std::string& from = new_id()) {
  PlaceRequest request{new_id(), new_id(), new_id()};
  request.visitor = true;
  request.visitor_from = from;
  return request;
}

TEST_F(SessionsTest, LimitsVisitorsToAQuarterOfAllSlots) {
  announce({.id = "a", .slots = 8});
  announce({.id = "b", .slots = 8});
  std::set<std::string> workers;
  for (int i = 0; i < 4; ++i) {
    const auto placed = sessions_.place(visit());
    ASSERT_TRUE(placed) << i << " " << placed.error().message;
    workers.insert(placed->worker_id);
  }
  EXPECT_EQ(sessions_.place(visit()).error().code, ErrorCode::kTooLarge);
  for (int i = 0; i < 12; ++i) EXPECT_TRUE(sessions_.place(request())) << i;
  EXPECT_EQ(client_->command({"ZCARD", "diaphane:refused"})->integer, 0)
      << "no fleet grows for visitors beyond their share";
}

TEST_F(SessionsTest, LimitsOneAddressToHalfOfTheVisitorSlots) {
  announce({.id = "a", .slots = 32});
  const std::string here = new_id();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(sessions_.place(visit(here))) << i;
  EXPECT_EQ(sessions_.place(visit(here)).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(sessions_.place(visit()));
}

TEST_F(SessionsTest, KeepsTheLastSlotForAccountHolders) {
  announce({.id = "a", .slots = 1});
  EXPECT_EQ(sessions_.place(visit()).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(sessions_.place(request()));
}

TEST_F(SessionsTest, AccountHolderDisplacesVisitorWhenNoSlotIsFree) {
  announce({.id = "a", .slots = 4});
  ASSERT_TRUE(sessions_.place(visit()));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(sessions_.place(request()));
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable)
      << "the worker has not said that the visitor came";
  ASSERT_TRUE(client_->command({"HSET", "diaphane:worker:a", "visitors", "1"}));
  const auto placed = sessions_.place(request());
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_TRUE(sessions_.consume(placed->ticket));
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable)
      << "there was one visitor";
  // No visitor is displaced while another worker has a free slot.
  announce({.id = "b", .slots = 4, .load = "0.9"});
  EXPECT_EQ(sessions_.place(request())->worker_id, "b");
}

TEST_F(SessionsTest, VisitorSessionBecomesRegularWhenItsOwnerOpensIt) {
  announce({.id = "a", .slots = 8});
  PlaceRequest once = visit();
  const auto first = sessions_.place(once);
  EXPECT_TRUE(sessions_.consume(first->ticket)->visitor);
  once.visitor = false;
  EXPECT_FALSE(sessions_.consume(sessions_.place(once)->ticket)->visitor);
  EXPECT_EQ(client_->command({"ZCARD", "diaphane:visitors"})->integer, 0);
  once.visitor = true;  // a guest's ticket: the slot remains the owner's
  EXPECT_FALSE(sessions_.consume(sessions_.place(once)->ticket)->visitor);
}

TEST_F(SessionsTest, PlacingASessionAgainKeepsItsWorkerAndIssuesANewTicket) {
  announce({.id = "a", .slots = 1});
  const PlaceRequest once = request();
  const auto first = sessions_.place(once);
  const auto second = sessions_.place(once);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->worker_id, first->worker_id);
  EXPECT_EQ(second->placement, first->placement);
  EXPECT_NE(second->ticket, first->ticket);
  EXPECT_EQ(used("a"), 1);
}

TEST_F(SessionsTest, MovesSessionFromGoneRestartedOrDrainingWorker) {
  announce({.id = "a"});
  const PlaceRequest once = request();
  ASSERT_EQ(sessions_.place(once)->placement, 1u);

  announce({.id = "a", .incarnation = "second"});
  EXPECT_EQ(sessions_.place(once)->placement, 2u);

  announce({.id = "a", .draining = "1", .incarnation = "second"});
  announce({.id = "b"});
  const auto moved = sessions_.place(once);
  EXPECT_EQ(moved->worker_id, "b");
  EXPECT_EQ(moved->placement, 3u);
  EXPECT_EQ(used("a"), 0);

  vanish("b");
  announce({.id = "c"});
  EXPECT_EQ(sessions_.place(once)->worker_id, "c");
  EXPECT_EQ(sessions_.place(once)->placement, 4u);
}

TEST_F(SessionsTest, AvoidsWorkerThatRanOutOfMemoryForAWhile) {
  Sessions patient(*client_, {.refused_ms = 300});
  announce({.id = "a", .slots = 4});
  const PlaceRequest one = request(), other = request();
  const auto placed = patient.place(one);
  ASSERT_TRUE(patient.place(other));
  ASSERT_TRUE(patient.refused(one.session_id, "a", placed->placement));
  EXPECT_EQ(used("a"), 1) << "its place there is given back, the other's kept";
  const auto nowhere = patient.place(one);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(nowhere.error().message, testing::HasSubstr("memory"));
  EXPECT_EQ(patient.place(other)->worker_id, "a") << "only what was refused goes elsewhere";

  announce({.id = "b", .slots = 1});
  const auto moved = patient.place(one);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->worker_id, "b");
  EXPECT_EQ(moved->placement, placed->placement + 1);
  ASSERT_TRUE(patient.refused(one.session_id, "a", placed->placement)) << "late, of a place before";
  EXPECT_EQ(patient.place(one)->placement, moved->placement);

  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  vanish("b");
  EXPECT_EQ(patient.place(one)->worker_id, "a") << "it may have memory again";
}

TEST_F(SessionsTest, SessionWithoutSlotIsPlacedOnlyWhereOneIsFree) {
  announce({.id = "a", .slots = 1});
  const PlaceRequest first = request();
  ASSERT_TRUE(sessions_.place(first));
  expire_entry("a", first.session_id);
  const PlaceRequest second = request();
  ASSERT_TRUE(sessions_.place(second));
  EXPECT_EQ(sessions_.place(first).error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(sessions_.find(first.session_id)) << "a refusal must not forget the session";
  ASSERT_TRUE(sessions_.end(second.session_id));
  EXPECT_EQ(sessions_.place(first)->placement, 2u);
}

TEST_F(SessionsTest, SessionOfAnotherUserIsNotFound) {
  announce({.id = "a"});
  const PlaceRequest mine = request();
  ASSERT_TRUE(sessions_.place(mine));
  PlaceRequest theirs = mine;
  theirs.user_id = new_id();
  EXPECT_EQ(sessions_.place(theirs).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(sessions_.find(mine.session_id)->user_id, mine.user_id);
}

TEST_F(SessionsTest, LimitsPlacedSessionsPerUser) {
  announce({.id = "a", .slots = 100});
  const std::string user = new_id();
  std::string first;
  for (int i = 0; i < 8; ++i) {
    const PlaceRequest one = request(user);
    if (i == 0) first = one.session_id;
    ASSERT_TRUE(sessions_.place(one));
  }
  EXPECT_EQ(sessions_.place(request(user)).error().code, ErrorCode::kTooMany);
  EXPECT_TRUE(sessions_.place(request())) << "another person is not concerned";
  ASSERT_TRUE(sessions_.end(first));
  EXPECT_TRUE(sessions_.place(request(user)));
}

TEST_F(SessionsTest, EvictsOldestUnplacedSessionOverTheLimit) {
  Sessions sessions(*client_, {.placed = 2, .remembered = 3});
  announce({.id = "a", .slots = 100});
  const std::string user = new_id();
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) {
    const PlaceRequest one = request(user);
    ASSERT_TRUE(sessions.place(one));
    expire_entry("a", one.session_id);
    ids.push_back(one.session_id);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_FALSE(sessions.find(ids[0]));
  const auto remembered = sessions.sessions_of(user);
  ASSERT_TRUE(remembered);
  std::vector<std::string> left;
  for (const SessionInfo& one : *remembered) left.push_back(one.id);
  EXPECT_THAT(left, ElementsAre(ids[1], ids[2], ids[3]));
}

TEST_F(SessionsTest, TicketWorksOnceAndLocatesTheSession) {
  announce({.id = "a", .incarnation = "x"});
  const PlaceRequest once = request();
  const auto placed = sessions_.place(once);
  const std::string key = "diaphane:session:" + once.session_id;
  const std::string scene("\0\x08 scene", 8);
  ASSERT_TRUE(client_->command(
      {"HSET", key, "scene", scene, "input_seq", "7", "width", "640", "height", "480"}));
  const auto found = sessions_.consume(placed->ticket);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->session.id, once.session_id);
  EXPECT_EQ(found->session.user_id, once.user_id);
  EXPECT_EQ(found->session.data_set_id, once.data_set_id);
  EXPECT_EQ(found->address, "a:8085");
  EXPECT_EQ(found->incarnation, "x");
  EXPECT_EQ(found->placement, 1u);
  EXPECT_EQ(found->scene, scene);
  EXPECT_EQ(found->input_seq, 7u);
  EXPECT_EQ(found->width, 640u);
  EXPECT_EQ(found->height, 480u);
  EXPECT_EQ(sessions_.consume(placed->ticket).error().code, ErrorCode::kUnauthenticated);
}

TEST_F(SessionsTest, ConcurrentUseOfATicketSucceedsOnce) {
  announce({.id = "a"});
  const auto placed = sessions_.place(request());
  std::atomic<int> served = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back(
          [&] { served += sessions_.consume(placed->ticket).has_value() ? 1 : 0; });
    }
  }
  EXPECT_EQ(served, 1);
}

TEST_F(SessionsTest, ATicketExpires) {
  Sessions sessions(*client_, {.ticket_s = 1});
  announce({.id = "a"});
  const auto placed = sessions.place(request());
  const auto left = client_->command({"PTTL", "diaphane:ticket:" + placed->ticket})->integer;
  EXPECT_GT(left, 0);
  EXPECT_LE(left, 1000);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  EXPECT_EQ(sessions.consume(placed->ticket).error().code, ErrorCode::kUnauthenticated);
}

TEST_F(SessionsTest, RefusesMalformedOrUnknownTicket) {
  for (const std::string& text : {std::string(), std::string("*"), std::string(64, 'G'),
                                  std::string(64, 'a'), std::string(65, 'a')}) {
    EXPECT_EQ(sessions_.consume(text).error().code, ErrorCode::kUnauthenticated);
  }
}

TEST_F(SessionsTest, TicketReportsLostWorkerOrEndedSession) {
  announce({.id = "a"});
  const PlaceRequest one = request();
  const auto before_loss = sessions_.place(one);
  announce({.id = "a", .incarnation = "second"});
  EXPECT_EQ(sessions_.consume(before_loss->ticket).error().code, ErrorCode::kUnavailable);
  const auto before_end = sessions_.place(one);
  ASSERT_TRUE(sessions_.end(one.session_id));
  EXPECT_EQ(sessions_.consume(before_end->ticket).error().code, ErrorCode::kNotFound);
}

TEST_F(SessionsTest, AReservationExpires) {
  Sessions sessions(*client_, {.reservation_ms = 100});
  announce({.id = "a", .slots = 1});
  ASSERT_TRUE(sessions.place(request()));
  EXPECT_EQ(sessions.place(request()).error().code, ErrorCode::kUnavailable);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_TRUE(sessions.place(request()));
  EXPECT_EQ(used("a"), 1);
}

TEST_F(SessionsTest, LateTicketDoesNotTakeAReassignedSlot) {
  announce({.id = "a", .slots = 1});
  const PlaceRequest late = request();
  const auto ticket = sessions_.place(late);
  expire_entry("a", late.session_id);
  ASSERT_TRUE(sessions_.place(request()));
  EXPECT_EQ(sessions_.consume(ticket->ticket).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(used("a"), 1);
}

TEST_F(SessionsTest, RemovesOnlyTheLostIncarnation) {
  announce({.id = "a", .incarnation = "second"});
  ASSERT_TRUE(sessions_.place(request()));
  EXPECT_FALSE(*sessions_.lost("a", "first"));
  EXPECT_EQ(used("a"), 1);
  EXPECT_TRUE(*sessions_.lost("a", "second"));
  EXPECT_EQ(used("a"), 0);
  EXPECT_TRUE(sessions_.alive()->empty());
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable);
}

TEST_F(SessionsTest, EndingADataSetEndsAllItsSessionsAndNoOthers) {
  announce({.id = "a", .slots = 10});
  const std::string data_set = new_id();
  const PlaceRequest first = request(new_id(), data_set), second = request(new_id(), data_set),
                     other = request(first.user_id);
  for (const PlaceRequest& one : {first, second, other}) ASSERT_TRUE(sessions_.place(one));
  ASSERT_TRUE(sessions_.end_all_of(data_set));
  EXPECT_FALSE(sessions_.find(first.session_id));
  EXPECT_FALSE(sessions_.find(second.session_id));
  EXPECT_TRUE(sessions_.find(other.session_id));
  EXPECT_EQ(used("a"), 1);
  EXPECT_TRUE(sessions_.end(first.session_id)) << "ending a session that is gone succeeds";
  EXPECT_EQ(sessions_.sessions_of(first.user_id)->size(), 1u);
}

TEST_F(SessionsTest, SignOutEndsOnlySessionsOfThatBrowser) {
  announce({.id = "a", .slots = 10});
  const std::string user = new_id(), left = new_id(), stays = new_id();
  PlaceRequest mine = request(user), shared = request(user), other = request(user);
  mine.browser = shared.browser = left;
  other.browser = stays;
  for (const PlaceRequest& one : {mine, shared, other}) ASSERT_TRUE(sessions_.place(one));
  shared.browser = stays;
  ASSERT_TRUE(sessions_.place(shared));
  const std::string unused = sessions_.place(mine)->ticket;

  ASSERT_TRUE(sessions_.end_all_from(left, user));
  EXPECT_FALSE(sessions_.find(mine.session_id));
  EXPECT_FALSE(sessions_.find(shared.session_id)) << "the browser may still be connected to it";
  EXPECT_TRUE(sessions_.find(other.session_id));
  EXPECT_EQ(sessions_.consume(unused).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(sessions_.place(mine).error().code, ErrorCode::kUnauthenticated)
      << "a request that was authenticated before the sign-out";
  EXPECT_TRUE(sessions_.place(shared));
  EXPECT_EQ(used("a"), 2);
}

TEST_F(SessionsTest, ASessionChargedToAUserCountsForThemButIsNotTheirs) {
  Sessions sessions(*client_, {.placed = 2});
  announce({.id = "a", .slots = 10});
  const std::string payer = new_id();
  PlaceRequest one = request(), two = request();
  one.charged_to = two.charged_to = payer;
  for (const PlaceRequest& each : {one, two}) ASSERT_TRUE(sessions.place(each));
  EXPECT_EQ(sessions.place(request(payer)).error().code, ErrorCode::kTooMany);
  EXPECT_TRUE(sessions.sessions_of(payer)->empty());
  EXPECT_EQ(sessions.find(one.session_id)->user_id, one.user_id);
  EXPECT_EQ(sessions.sessions_on(one.data_set_id)->at(0).charged_to, payer);
  PlaceRequest stolen = one;
  stolen.user_id = payer;
  EXPECT_EQ(sessions.place(stolen).error().code, ErrorCode::kNotFound);

  ASSERT_TRUE(sessions.end_all_from(new_id(), payer));
  EXPECT_TRUE(sessions.find(one.session_id)) << "it belongs to no browser of theirs";
  ASSERT_TRUE(sessions.end(two.session_id));
  EXPECT_TRUE(sessions.place(request(payer)));
  ASSERT_TRUE(sessions.end_all_by(payer));
  EXPECT_FALSE(sessions.find(one.session_id));
}

TEST_F(SessionsTest, SignOutEndsRestoredSessionWithUnknownBrowser) {
  announce({.id = "a"});
  PlaceRequest one = request();
  one.browser = new_id();
  ASSERT_TRUE(sessions_.place(one));
  ASSERT_TRUE(client_->command({"HDEL", "diaphane:session:" + one.session_id, "browsers"}));
  ASSERT_TRUE(sessions_.end_all_from(new_id(), new_id()));
  EXPECT_TRUE(sessions_.find(one.session_id));
  ASSERT_TRUE(sessions_.end_all_from(one.browser, one.user_id));
  EXPECT_FALSE(sessions_.find(one.session_id));
}

TEST_F(SessionsTest, AllKeysExpire) {
  announce({.id = "a"});
  ASSERT_TRUE(sessions_.place(request()));
  const Result<Reply> keys = client_->command({"KEYS", "*"});
  for (const Reply& key : keys->list) {
    if (key.text == "diaphane:workers" || key.text == "diaphane:worker:a") continue;
    EXPECT_GT(client_->command({"TTL", key.text})->integer, 0) << key.text;
  }
}

TEST_F(SessionsTest, LinkResolvesToItsSessionUntilItEnds) {
  announce({.id = "a"});
  Links links(*client_);
  const PlaceRequest mine = request();
  ASSERT_TRUE(sessions_.place(mine));
  const std::string hash(64, 'b');
  EXPECT_EQ(links.make(mine.session_id, new_id(), hash, false).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(links.make(mine.session_id, mine.user_id, hash, false));
  EXPECT_EQ(links.follow(hash)->session.user_id, mine.user_id);
  PlaceRequest guest = mine;
  guest.participant = new_id();
  guest.name = "Ann";
  guest.link = hash;
  const auto attachment = sessions_.consume(sessions_.place(guest)->ticket);
  ASSERT_TRUE(attachment);
  EXPECT_EQ(attachment->participant, guest.participant);
  EXPECT_EQ(attachment->name, "Ann");
  EXPECT_EQ(attachment->link, hash);
  EXPECT_TRUE(sessions_.consume(sessions_.place(mine)->ticket)->participant.empty());
  EXPECT_THAT(*sessions_.ended_links({hash}), testing::IsEmpty());
  const std::string late = sessions_.place(guest)->ticket;
  ASSERT_TRUE(links.end_links(mine.session_id));
  EXPECT_EQ(links.follow(hash).error().code, ErrorCode::kNotFound);
  EXPECT_THAT(*sessions_.ended_links({hash, std::string(64, 'c')}), ElementsAre(hash));
  EXPECT_EQ(sessions_.consume(late).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(sessions_.consume(sessions_.place(mine)->ticket)) << "the owner's own way stays";
}

TEST_F(SessionsTest, EachLinkKeepsItsOwnPermission) {
  announce({.id = "a"});
  Links links(*client_);
  const PlaceRequest mine = request();
  ASSERT_TRUE(sessions_.place(mine));
  const std::string narrow(64, 'b'), wide(64, 'c');
  ASSERT_TRUE(links.make(mine.session_id, mine.user_id, narrow, false));
  ASSERT_TRUE(links.make(mine.session_id, mine.user_id, wide, true));
  EXPECT_FALSE(links.follow(narrow)->slices);
  EXPECT_TRUE(links.follow(wide)->slices);
  EXPECT_EQ(links.follow(wide)->session.id, mine.session_id);
  EXPECT_TRUE(links.make(mine.session_id, mine.user_id, wide, true)) << "a repetition";
  EXPECT_EQ(links.make(mine.session_id, mine.user_id, narrow, true).error().code,
            ErrorCode::kInvalid);
  EXPECT_FALSE(links.follow(narrow)->slices);
}

TEST_F(SessionsTest, TicketCarriesSlicesAndDownloads) {
  announce({.id = "a"});
  for (int bits = 0; bits < 4; ++bits) {
    PlaceRequest one = request();
    one.slices = (bits & 1) != 0;
    one.downloads = (bits & 2) != 0;
    const auto attachment = sessions_.consume(sessions_.place(one)->ticket);
    ASSERT_TRUE(attachment);
    EXPECT_EQ(attachment->slices, one.slices);
    EXPECT_EQ(attachment->downloads, one.downloads);
    ASSERT_TRUE(sessions_.end(one.session_id));
  }
}

TEST_F(SessionsTest, LimitsLinksPerSessionAndEndsThemWithIt) {
  announce({.id = "a"});
  Links links(*client_);
  const PlaceRequest mine = request();
  ASSERT_TRUE(sessions_.place(mine));
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(links.make(mine.session_id, mine.user_id, std::string(64, char('0' + i)), false));
  }
  EXPECT_EQ(links.make(mine.session_id, mine.user_id, std::string(64, 'x'), false).error().code,
            ErrorCode::kTooMany);
  ASSERT_TRUE(sessions_.end(mine.session_id));
  EXPECT_EQ(links.follow(std::string(64, '3')).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace diaphane::directory
