#include "api/scans/data_sets.h"

#include "tests/support/api/data_set_fixture.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

class DataSetsTest : public DataSetFixture {
 protected:
  static DataSets::Announcement upload_of(std::int64_t bytes, const std::string& key = "") {
    return {"Head", bytes, key};
  }
};

TEST_F(DataSetsTest, NewScanBelongsToTheUserAndExpiresAfterADayWithoutData) {
  const auto made = data_sets.announce(owner, upload_of(1000));
  ASSERT_TRUE(made);
  EXPECT_EQ(made->title, "Head");
  EXPECT_TRUE(made->owned());
  ASSERT_EQ(data_set_store.created.size(), 1u);
  const auto& [wanted, now] = data_set_store.created[0];
  EXPECT_EQ(wanted.owner.user_id, owner.user_id);
  EXPECT_EQ(wanted.bytes, 1000);
  EXPECT_EQ(now, clock.wall());
  EXPECT_EQ(wanted.expires_at, clock.wall() + 24h);
  EXPECT_EQ(data_set_store.limits.unprocessed, 50);
  EXPECT_EQ(data_set_store.limits.all, 2000);
}

TEST_F(DataSetsTest, AnUploadHasAtMostEightGibibytes) {
  const std::int64_t most = std::int64_t{8} << 30;
  EXPECT_TRUE(data_sets.announce(owner, upload_of(most)));
  EXPECT_EQ(refusal(data_sets.announce(owner, upload_of(most + 1))), ProblemKind::kUploadTooLarge);
}

TEST_F(DataSetsTest, RefusesScansThatNeedTheDiskReserve) {
  free_bytes = (std::int64_t{1} << 30) + 1000;
  EXPECT_TRUE(data_sets.announce(owner, upload_of(1000)));
  const auto refused = data_sets.announce(owner, upload_of(1001));
  ASSERT_EQ(refusal(refused), ProblemKind::kStorageFull);
  EXPECT_EQ(refused.error().retry_after, 10min);
}

TEST_F(DataSetsTest, QuotaErrorStatesQuotaAndUse) {
  data_set_store.creation = OverQuota{{20'000'000, 15'000'000}};
  const auto refused = data_sets.announce(owner, upload_of(7'000'000));
  ASSERT_EQ(refusal(refused), ProblemKind::kOverQuota);
  EXPECT_EQ(refused.error().detail,
            "This scan needs 7 MB, but 15 MB of your 20 MB of storage are already in use. Delete "
            "other scans first.");
}

TEST_F(DataSetsTest, OnlyTheLimitOfUnprocessedScansAsksToRetryLater) {
  data_set_store.creation = TooManyDataSets{true};
  const auto unprocessed = data_sets.announce(owner, upload_of(1));
  ASSERT_EQ(refusal(unprocessed), ProblemKind::kTooMany);
  EXPECT_EQ(unprocessed.error().retry_after, 1min);
  EXPECT_EQ(unprocessed.error().detail.substr(0, 3), "50 ");

  data_set_store.creation = TooManyDataSets{false};
  const auto all = data_sets.announce(owner, upload_of(1));
  ASSERT_EQ(refusal(all), ProblemKind::kTooManyDataSets);
  EXPECT_EQ(all.error().retry_after, 0s);
  EXPECT_NE(all.error().detail.find("2000 scans"), std::string::npos);
}

TEST_F(DataSetsTest, ARepeatedRequestWithItsKeyCreatesNothing) {
  const auto first = data_sets.announce(owner, upload_of(1000, "key"));
  ASSERT_TRUE(first);
  EXPECT_EQ(data_sets.announce(owner, upload_of(1000, "key"))->id, first->id);
  EXPECT_EQ(data_set_store.created.size(), 1u);
  EXPECT_NE(data_sets.announce(owner, upload_of(1000, "other key"))->id, first->id);
  EXPECT_NE(data_sets.announce(owner, upload_of(1000))->id, first->id);
}

TEST_F(DataSetsTest, RefusesAKeyReusedForAnotherSizeOrTitle) {
  ASSERT_TRUE(data_sets.announce(owner, upload_of(1000, "key")));
  EXPECT_EQ(refusal(data_sets.announce(owner, upload_of(1001, "key"))),
            ProblemKind::kIdempotencyKeyReused);
  EXPECT_EQ(refusal(data_sets.announce(owner, {"Knee", 1000, "key"})),
            ProblemKind::kIdempotencyKeyReused);
}

TEST_F(DataSetsTest, KeyOfADeletedScanIsAConflict) {
  const auto first = data_sets.announce(owner, upload_of(1000, "key"));
  data_set_store.data_sets.erase(first->id);
  EXPECT_EQ(refusal(data_sets.announce(owner, upload_of(1000, "key"))), ProblemKind::kConflict);
}

TEST_F(DataSetsTest, SampleUploadsIgnoreKeys) {
  Principal sample_operator;
  sample_operator.sample_operator = true;
  const auto first = data_sets.announce(sample_operator, upload_of(1000, "key"));
  const auto second = data_sets.announce(sample_operator, upload_of(1000, "key"));
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->id, second->id);
}

TEST_F(DataSetsTest, APageEndsWithACursorOnlyIfThereIsMore) {
  const auto at = clock.wall() + 123456us;
  for (int i = 0; i < 3; ++i) {
    DataSet one;
    one.id = new_id();
    one.created_at = at - i * 1s;
    data_set_store.listed.push_back(one);
  }
  const auto all = data_sets.list(owner, {}, 3);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->items.size(), 3u);
  EXPECT_FALSE(all->next);
  const auto some = data_sets.list(owner, {}, 2);
  ASSERT_TRUE(some);
  EXPECT_EQ(some->items.size(), 2u);
  const std::chrono::microseconds last = (at - 1s).time_since_epoch() / 1us * 1us;
  EXPECT_EQ(some->next, (Cursor{last.count(), data_set_store.listed[1].id}));
}

TEST_F(DataSetsTest, ActionsFollowThePermissionTable) {
  for (const Action action : kActions) {
    expect_permission(action, [&](const Principal& who) {
      return refusal(data_sets.authorise(who, id, action));
    });
  }
}

TEST_F(DataSetsTest, MalformedIdIsNotFoundWithoutAQuery) {
  for (const std::string& bad : {std::string(), std::string("1"), id + "x"}) {
    EXPECT_EQ(refusal(data_sets.find(owner, bad)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(data_set_store.calls("find"), 0);
  EXPECT_EQ(refusal(data_sets.find(owner, new_id())), ProblemKind::kNotFound);
}

TEST_F(DataSetsTest, OnlyAScanThatIsReadyCanBeViewed) {
  for (const auto& [state, name] :
       {std::pair(DataSetState::kUploading, "uploading"),
        std::pair(DataSetState::kQueued, "queued"), std::pair(DataSetState::kBuilding, "building"),
        std::pair(DataSetState::kRefused, "refused"),
        std::pair(DataSetState::kExpired, "expired")}) {
    scan().state = state;
    const auto refused = data_sets.find_ready(owner, id);
    ASSERT_EQ(refusal(refused), ProblemKind::kNotReady);
    EXPECT_EQ(refused.error().detail,
              "This scan is not ready yet. Its state is " + std::string(name) + ".");
    EXPECT_EQ(refusal(data_sets.find_ready(stranger, id)), ProblemKind::kNotFound);
    EXPECT_TRUE(data_sets.find(owner, id));
  }
  scan().state = DataSetState::kReady;
  EXPECT_TRUE(data_sets.find_ready(owner, id));
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(data_sets.find_ready(who, id)); });
}

TEST_F(DataSetsTest, StatesHaveNamesAndAnUnknownNameIsExpired) {
  for (const auto state : {DataSetState::kUploading, DataSetState::kQueued, DataSetState::kBuilding,
                           DataSetState::kReady, DataSetState::kRefused, DataSetState::kExpired}) {
    EXPECT_EQ(data_set_state_of(to_string(state)), state);
  }
  EXPECT_EQ(data_set_state_of("lost"), DataSetState::kExpired);
}

TEST_F(DataSetsTest, OnlyTheOwnerDescribesAScan) {
  expect_permission(Action::kDescribe, [&](const Principal& who) {
    return refusal(data_sets.describe(who, id, {.title = "Knee", .text = {}, .body_part = {}}));
  });
  const auto described =
      data_sets.describe(owner, id, {.title = "Hip", .text = {}, .body_part = {}});
  EXPECT_EQ(described->title, "Hip");
  EXPECT_EQ(described->updated_at, clock.wall());
  data_set_store.break_function("describe", ErrorCode::kNotFound);
  EXPECT_EQ(refusal(data_sets.describe(owner, id, {})), ProblemKind::kNotFound);
}

TEST_F(DataSetsTest, OnlyTheOwnerDeletesAScan) {
  expect_permission(Action::kDelete, [&](const Principal& who) {
    const DataSet kept = scan();
    const Refusal refused = refusal(data_sets.remove(who, id));
    scan() = kept;
    return refused;
  });
  for (const std::string& by : data_set_store.removed) EXPECT_EQ(by, owner.user_id + " " + id);
}

TEST_F(DataSetsTest, DeletingAScanEndsItsSessionsAndDeletesItsFilesAtOnce) {
  int woken = 0;
  signals.subscribe(Signal::kDisposal, [&] { ++woken; });
  ASSERT_TRUE(data_sets.remove(owner, id));
  EXPECT_EQ(placement.ended, std::vector{"of " + id});
  EXPECT_EQ(woken, 1);
  EXPECT_EQ(refusal(data_sets.remove(owner, id)), ProblemKind::kNotFound);
}

TEST_F(DataSetsTest, AScanCanBeDeletedWithoutTheSessionDirectory) {
  placement.away = true;
  EXPECT_TRUE(data_sets.remove(owner, id));
}

TEST_F(DataSetsTest, NothingIsEndedIfAnotherRequestDeletedTheScanFirst) {
  int woken = 0;
  signals.subscribe(Signal::kDisposal, [&] { ++woken; });
  data_set_store.break_function("remove", ErrorCode::kNotFound);
  EXPECT_EQ(refusal(data_sets.remove(owner, id)), ProblemKind::kNotFound);
  EXPECT_TRUE(placement.ended.empty());
  EXPECT_EQ(woken, 0);
}

TEST_F(DataSetsTest, AViewIsInTheOwnersLogAndInTheAuditLog) {
  const std::string link = new_id(), visit = new_id();
  ASSERT_TRUE(data_sets.note_view(id, {ViewRoute::kLink, visit, link, {"203.0.113.77", "Edge"}}));
  ASSERT_EQ(data_set_store.noted_views.size(), 1u);
  EXPECT_EQ(data_set_store.noted_views[0].viewer, visit);
  const AuditEntry& entry = data_set_store.accesses.at(0);
  EXPECT_EQ(entry.actor, AuditActor::kPerson);
  EXPECT_EQ(entry.actor_id, "") << "a visitor has no account";
  EXPECT_EQ(entry.action, "data-set.looked-at");
  EXPECT_EQ(entry.subject_id, id);
  EXPECT_EQ(details_as_json(entry.details), R"({"by":"link","link":")" + link + "\"}");

  ASSERT_TRUE(data_sets.note_view(id, {ViewRoute::kAdministrator, "boss", "", {}}));
  EXPECT_EQ(data_set_store.accesses.at(1).actor, AuditActor::kAdministrator);
  EXPECT_EQ(data_set_store.accesses.at(1).actor_id, "boss");
  EXPECT_EQ(details_as_json(data_set_store.accesses.at(1).details), R"({"by":"administrator"})");
}

TEST_F(DataSetsTest, EachViewRouteHasAName) {
  for (const auto& [route, name] : kViewRoutes) {
    EXPECT_EQ(to_string(route), name);
    EXPECT_EQ(view_route_of(name), route);
    EXPECT_TRUE(is_code_word(name));
  }
}

TEST_F(DataSetsTest, OnlyTheOwnerReadsWhoViewedAScan) {
  expect_permission(Action::kReadViews, [&](const Principal& who) {
    return refusal(data_sets.views(who, id, {.limit = 5}));
  });
}

TEST_F(DataSetsTest, APageOfViewsEndsAtTheLastViewOfItsLastEntry) {
  for (int i = 0; i < 3; ++i) {
    ViewEntry& entry = data_set_store.view_log.emplace_back();
    entry.id = new_id();
    entry.first_at = clock.wall() - 1h;
    entry.last_at = clock.wall() - i * 1s;
  }
  const auto all = data_sets.views(owner, id, {.own = false, .limit = 3});
  ASSERT_TRUE(all);
  EXPECT_EQ(all->items.size(), 3u);
  EXPECT_FALSE(all->next);
  EXPECT_FALSE(data_set_store.view_query.own);
  const auto some = data_sets.views(owner, id, {.limit = 2});
  ASSERT_TRUE(some);
  EXPECT_EQ(some->items.size(), 2u);
  const std::chrono::microseconds last = (clock.wall() - 1s).time_since_epoch() / 1us * 1us;
  EXPECT_EQ(some->next, (Cursor{last.count(), data_set_store.view_log[1].id}));
}

TEST_F(DataSetsTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {data_set_store, "create", [&] { return refusal(data_sets.announce(owner, upload_of(1))); }},
      {data_set_store, "find", [&] { return refusal(data_sets.announce(owner, upload_of(1))); }},
      {data_set_store, "list", [&] { return refusal(data_sets.list(owner, {}, 1)); }},
      {data_set_store, "find", [&] { return refusal(data_sets.find(owner, id)); }},
      {data_set_store, "find", [&] { return refusal(data_sets.find_ready(owner, id)); }},
      {data_set_store, "describe", [&] { return refusal(data_sets.describe(owner, id, {})); }},
      {data_set_store, "remove", [&] { return refusal(data_sets.remove(owner, id)); }},
      {data_set_store, "note_view", [&] { return refusal(data_sets.note_view(id, {})); }},
      {data_set_store, "views", [&] { return refusal(data_sets.views(owner, id, {})); }},
  });
}

}  // namespace
}  // namespace diaphane::api
