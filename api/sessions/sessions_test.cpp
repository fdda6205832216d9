#include "api/sessions/sessions.h"

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_error_curves.h"
#include "tests/support/api/fake_render_time_store.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

class SessionsTest : public DataSetFixture {
 protected:
  FakeRenderTimeStore render_time_store;
  FakeSpentRenderTime spent;
  RenderTime render_time{render_time_store, spent, placement, clock};
  FakeErrorCurves error_curves;
  Outcome<std::string> motion;
  Sessions sessions{
      data_sets,
      placement,
      render_time,
      error_curves,
      [](const std::string& data_set_id) { return "scene of " + data_set_id; },
      [this](const Principal&, const std::string&, const std::string&) { return motion; }};
};

TEST_F(SessionsTest, OpenPassesTheScanItsFirstSceneAndTheBrowser) {
  const auto opened = sessions.open(owner, id, "", "");
  ASSERT_TRUE(opened);
  EXPECT_TRUE(is_id(opened->session_id));
  EXPECT_EQ(opened->stream_url, "/stream?ticket=ticket1");
  ASSERT_EQ(placement.requests.size(), 1u);
  const PlaceRequest& request = placement.requests[0];
  EXPECT_EQ(request.session_id, opened->session_id);
  EXPECT_EQ(request.user_id, owner.user_id);
  EXPECT_EQ(request.data_set_id, id);
  EXPECT_EQ(request.first_scene, "scene of " + id);
  EXPECT_EQ(request.browser, owner.session_id);
  EXPECT_FALSE(request.visitor);
}

TEST_F(SessionsTest, OnlyThoseWhoMayViewAScanOpenASessionOnIt) {
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(sessions.open(who, id, "", "")); });
}

TEST_F(SessionsTest, TheWorkerLearnsHowTheViewerIsRelatedToTheScan) {
  expose(Exposure::kPublic);
  for (const auto& [role, viewer] : {std::pair(Role::kOwner, SessionViewer::kOwner),
                                     std::pair(Role::kSharedView, SessionViewer::kShared),
                                     std::pair(Role::kSharedEdit, SessionViewer::kShared),
                                     std::pair(Role::kOther, SessionViewer::kPublic),
                                     std::pair(Role::kAdministrator, SessionViewer::kPublic)}) {
    ASSERT_TRUE(sessions.open(as(role), id, "", ""));
    EXPECT_EQ(placement.requests.back().viewer, viewer) << to_string(role);
  }
}

TEST_F(SessionsTest, EachViewIsRecordedWithItsRoute) {
  expose(Exposure::kPublic);
  for (const auto& [role, route] : {std::pair(Role::kOwner, ViewRoute::kOwner),
                                    std::pair(Role::kSharedView, ViewRoute::kPerson),
                                    std::pair(Role::kSharedEdit, ViewRoute::kPerson),
                                    std::pair(Role::kOther, ViewRoute::kGallery),
                                    std::pair(Role::kAdministrator, ViewRoute::kAdministrator)}) {
    Principal who = as(role);
    who.client = {"203.0.113.77", "Firefox on Windows"};
    const auto opened = sessions.open(who, id, "", "");
    ASSERT_TRUE(opened);
    const View& view = data_set_store.noted_views.back();
    EXPECT_EQ(view.route, route) << to_string(role);
    EXPECT_EQ(view.viewer, who.user_id);
    EXPECT_EQ(view.client.address, "203.0.113.77");
    EXPECT_EQ(view.client.browser, "Firefox on Windows");
    ASSERT_TRUE(sessions.ticket(who, opened->session_id));
  }
  EXPECT_EQ(data_set_store.noted_views.size(), 10u) << "a new ticket is a view too";
  EXPECT_EQ(data_set_store.accesses.size(), 10u);
}

TEST_F(SessionsTest, AScanIsNotShownUnlessTheViewIsRecorded) {
  data_set_store.break_function("note_view");
  EXPECT_EQ(refusal(sessions.open(shared, id, "", "")), ProblemKind::kUnavailable);
  expose(Exposure::kSample);
  EXPECT_TRUE(sessions.open(shared, id, "", "")) << "nobody owns a sample";
  EXPECT_TRUE(data_set_store.noted_views.empty());
}

TEST_F(SessionsTest, SlicesAndDownloadsAreThoseThatTheOwnerAllows) {
  // Returns whether slices and downloads are allowed, as two digits.
  const auto allowed = [&](const Principal& who) {
    EXPECT_TRUE(sessions.open(who, id, "", ""));
    const PlaceRequest& request = placement.requests.back();
    return std::to_string(int{request.slices}) + std::to_string(int{request.downloads});
  };
  EXPECT_EQ(allowed(owner), "11");
  EXPECT_EQ(allowed(shared), "00");
  scan().to_public = {true, true};
  EXPECT_EQ(allowed(shared), "00") << "it is not public";
  expose(Exposure::kPublic);
  EXPECT_EQ(allowed(shared), "11");
  EXPECT_EQ(allowed(stranger), "11");
  scan().to_public = {false, true};
  EXPECT_EQ(allowed(stranger), "01");
  scan().to_public = {true, false};
  EXPECT_EQ(allowed(stranger), "10");
  scan().to_public = {};
  scan().to_person = {false, true};
  EXPECT_EQ(allowed(shared), "01");
  scan().to_person = {true, false};
  EXPECT_EQ(allowed(shared), "10");
  scan().to_person = {};
  expose(Exposure::kSample);
  EXPECT_EQ(allowed(stranger), "11");
}

TEST_F(SessionsTest, PermissionsWithdrawnDuringThePlacementDoNotApply) {
  scan().to_person = {true, true};
  placement.before("place", [&] { scan().to_person.downloads = false; });
  EXPECT_EQ(refusal(sessions.open(shared, id, "", "")), ProblemKind::kBusy);
  EXPECT_EQ(placement.ended.size(), 1u);
  EXPECT_TRUE(sessions.open(shared, id, "", ""));
  EXPECT_FALSE(placement.requests.back().downloads);
}

TEST_F(SessionsTest, AScanThatIsNotReadyHasNoSessions) {
  scan().state = DataSetState::kBuilding;
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), ProblemKind::kNotReady);
  EXPECT_TRUE(placement.requests.empty());
}

TEST_F(SessionsTest, RefusesSessionsWithoutRenderingTime) {
  render_time_store.accounts[owner.user_id] = {.quota_ms = 1000, .used_ms = 1000};
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), ProblemKind::kRenderTimeSpent);
  EXPECT_TRUE(placement.requests.empty());
}

TEST_F(SessionsTest, ARepeatedRequestWithItsKeyOpensTheSameSession) {
  const auto first = sessions.open(owner, id, "", "key");
  const auto again = sessions.open(owner, id, "", "key");
  ASSERT_TRUE(first && again);
  EXPECT_EQ(again->session_id, first->session_id);
  EXPECT_NE(again->stream_url, first->stream_url) << "a ticket works once";
  EXPECT_NE(sessions.open(owner, id, "", "other key")->session_id, first->session_id);
  EXPECT_NE(sessions.open(owner, id, "", "")->session_id,
            sessions.open(owner, id, "", "")->session_id);
}

TEST_F(SessionsTest, RefusesAKeyReusedForAnotherScanOrUser) {
  const auto first = sessions.open(owner, id, "", "key");
  EXPECT_EQ(refusal(sessions.open(owner, add_scan(), "", "key")),
            ProblemKind::kIdempotencyKeyReused);
  const auto other = sessions.open(shared, id, "", "key");
  ASSERT_TRUE(other);
  EXPECT_NE(other->session_id, first->session_id);
}

TEST_F(SessionsTest, EachPlacementFailureHasItsOwnError) {
  for (const auto& [code, kind] :
       {std::pair(ErrorCode::kUnavailable, ProblemKind::kNoWorker),
        std::pair(ErrorCode::kNotFound, ProblemKind::kNotFound),
        std::pair(ErrorCode::kUnauthenticated, ProblemKind::kUnauthenticated),
        std::pair(ErrorCode::kTooMany, ProblemKind::kTooMany),
        std::pair(ErrorCode::kInternal, ProblemKind::kInternal)}) {
    placement.break_function("place", code);
    EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), kind);
  }
  placement.break_function("place");
  EXPECT_EQ(sessions.open(owner, id, "", "").error().retry_after, 2s);
  placement.is_reachable = false;
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), ProblemKind::kUnavailable)
      << "without Redis, nobody knows whether there are workers";
}

TEST_F(SessionsTest, SessionEndsIfAccessWasWithdrawnDuringPlacement) {
  placement.before("place", [&] { data_set_store.data_sets.erase(id); });
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), ProblemKind::kNotFound);
  ASSERT_EQ(placement.requests.size(), 1u);
  EXPECT_EQ(placement.ended, std::vector{placement.requests[0].session_id});
}

TEST_F(SessionsTest, AListHasTheSessionsOfItsUserOnly) {
  const std::string mine = sessions.open(owner, id, "", "")->session_id;
  ASSERT_TRUE(sessions.open(shared, id, "", ""));
  const auto found = sessions.list(owner);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 1u);
  EXPECT_EQ((*found)[0].id, mine);
}

TEST_F(SessionsTest, SessionsOfOthersAreNotFound) {
  const std::string mine = sessions.open(owner, id, "", "")->session_id;
  EXPECT_EQ(sessions.find(owner, mine)->data_set_id, id);
  for (const std::string& other : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(sessions.find(owner, other)), ProblemKind::kNotFound);
  }
  for (const Principal& who : {shared, administrator}) {
    EXPECT_EQ(refusal(sessions.find(who, mine)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(sessions.end(who, mine)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(sessions.ticket(who, mine)), ProblemKind::kNotFound);
  }
  EXPECT_TRUE(placement.ended.empty());
  ASSERT_TRUE(sessions.end(owner, mine));
  EXPECT_EQ(placement.ended, std::vector{mine});
}

TEST_F(SessionsTest, ErrorCurveComesFromTheWorkerOfTheSession) {
  const std::string session = sessions.open(owner, id, "", "")->session_id;
  const auto before = sessions.error_curve(owner, session);
  ASSERT_TRUE(before);
  EXPECT_TRUE(before->points.empty()) << "nothing was rendered yet";
  error_curves.curves["worker/" + session] = {3, {{16, 0.5, 0.25}}};
  const auto curve = sessions.error_curve(owner, session);
  ASSERT_TRUE(curve);
  EXPECT_EQ(curve->epoch, 3u);
  EXPECT_EQ(curve->points.size(), 1u);
  for (const Principal& who : {shared, administrator}) {
    EXPECT_EQ(refusal(sessions.error_curve(who, session)), ProblemKind::kNotFound);
  }
  error_curves.break_function("find");
  EXPECT_EQ(refusal(sessions.error_curve(owner, session)), ProblemKind::kUnavailable);
}

TEST_F(SessionsTest, TicketKeepsTheSessionOnAnyWorker) {
  const auto opened = sessions.open(owner, id, "", "");
  const auto again = sessions.ticket(owner, opened->session_id);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->session_id, opened->session_id);
  EXPECT_EQ(again->stream_url, "/stream?ticket=ticket2");
}

TEST_F(SessionsTest, RefusesTicketsForMissingOrUnfinishedScans) {
  const std::string session = sessions.open(owner, id, "", "")->session_id;
  scan().state = DataSetState::kQueued;
  EXPECT_EQ(refusal(sessions.ticket(owner, session)), ProblemKind::kNotReady);
  data_set_store.data_sets.erase(id);
  const auto refused = sessions.ticket(owner, session);
  ASSERT_EQ(refusal(refused), ProblemKind::kNotFound);
  EXPECT_EQ(refused.error().detail, "Session not found.");
  EXPECT_EQ(placement.requests.size(), 1u);
}

TEST_F(SessionsTest, OpenSessionContinuesDuringTheGracePeriod) {
  const std::string session = sessions.open(owner, id, "", "")->session_id;
  render_time_store.accounts[owner.user_id] = {
      .quota_ms = 1000, .used_ms = 1000, .warned_at = clock.wall()};
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "")), ProblemKind::kRenderTimeSpent);
  EXPECT_TRUE(sessions.ticket(owner, session));
  clock.advance(2min);
  EXPECT_EQ(refusal(sessions.ticket(owner, session)), ProblemKind::kRenderTimeSpent);
}

TEST_F(SessionsTest, ReportsAnUnavailableStore) {
  const std::string session = sessions.open(owner, id, "", "")->session_id;
  const auto open = [&] { return refusal(sessions.open(owner, id, "", "key")); };
  const auto ticket = [&] { return refusal(sessions.ticket(owner, session)); };
  placement.is_reachable = false;
  expect_unavailable({
      {data_set_store, "find", open},
      {render_time_store, "account", open},
      {placement, "find", open},
      {placement, "place", open},
      {placement, "sessions_of", [&] { return refusal(sessions.list(owner)); }},
      {placement, "find", [&] { return refusal(sessions.find(owner, session)); }},
      {placement, "end", [&] { return refusal(sessions.end(owner, session)); }},
      {placement, "find", ticket},
      {data_set_store, "find", ticket},
      {render_time_store, "account", ticket},
      {placement, "place", ticket},
  });
}

TEST_F(SessionsTest, ASecondScanComesWithItsMotion) {
  const std::string other = add_scan();
  motion = "1 0 0";
  const auto opened = sessions.open(owner, id, other, "key");
  ASSERT_TRUE(opened);
  const PlaceRequest& request = placement.requests.back();
  EXPECT_EQ(request.data_set_id, id);
  EXPECT_EQ(request.over, other);
  EXPECT_EQ(request.to_first, "1 0 0");
  EXPECT_EQ(data_set_store.noted_views.size(), 2u) << "both scans were viewed";
  EXPECT_EQ(sessions.find(owner, opened->session_id)->over, other);
  EXPECT_EQ(sessions.open(owner, id, other, "key")->session_id, opened->session_id);
  EXPECT_EQ(refusal(sessions.open(owner, id, "", "key")), ProblemKind::kIdempotencyKeyReused);
  motion = refuse(ProblemKind::kNotAligned, "");
  EXPECT_EQ(refusal(sessions.open(owner, id, other, "")), ProblemKind::kNotAligned);
  EXPECT_TRUE(sessions.ticket(owner, opened->session_id)) << "the session keeps its motion";
}

TEST_F(SessionsTest, BothScansOfASessionMustBeVisible) {
  const std::string other = add_scan();
  EXPECT_EQ(refusal(sessions.open(shared, id, other, "")), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(sessions.open(shared, other, id, "")), ProblemKind::kNotFound);
  data_set_store.roles[{"shared-view", other}] = Role::kSharedView;
  const auto opened = sessions.open(shared, id, other, "");
  ASSERT_TRUE(opened);
  EXPECT_TRUE(sessions.ticket(shared, opened->session_id));
  data_set_store.roles.erase({"shared-view", other});
  EXPECT_EQ(refusal(sessions.ticket(shared, opened->session_id)), ProblemKind::kNotFound);
}

TEST_F(SessionsTest, OfTwoScansAViewerMayDoWhatBothAllow) {
  const std::string other = add_scan();
  const std::string who = shared.user_id;
  data_set_store.roles[{who, id}] = Role::kOwner;
  data_set_store.roles[{who, other}] = Role::kSharedView;
  data_set_store.data_sets[other].to_person = {.slices = true, .downloads = false};
  for (const auto& [first, second] : {std::pair(id, other), std::pair(other, id)}) {
    ASSERT_TRUE(sessions.open(shared, first, second, ""));
    EXPECT_EQ(placement.requests.back().viewer, SessionViewer::kShared);
    EXPECT_TRUE(placement.requests.back().slices);
    EXPECT_FALSE(placement.requests.back().downloads);
  }
}

}  // namespace
}  // namespace diaphane::api
