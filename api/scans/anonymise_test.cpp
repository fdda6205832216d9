#include "api/scans/anonymise.h"

#include <gmock/gmock.h>

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_stills.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class FakeCutStore final : public CutStore, public Fake {
 public:
  std::vector<std::pair<CutOrder, Time>> orders;

  Result<CutFacts> facts(const std::string&) override {
    DIAPHANE_TRY(enter("facts"));
    return CutFacts{"head", "problem"};
  }
  Result<void> order(const CutOrder& wanted, Time now) override {
    DIAPHANE_TRY(enter("order"));
    orders.emplace_back(wanted, now);
    return {};
  }
};

class AnonymiseTest : public DataSetFixture {
 protected:
  AnonymiseTest() {
    signals.subscribe(Signal::kDisposal, [this] { ++woken; });
  }
  Refusal cut(const std::string& hash = "hash") {
    return refusal(anonymise.cut(owner, id, "region", hash));
  }

  const TemporaryDirectory cache;
  FakeCutStore store;
  FakeStills stills;
  Thumbnails thumbnails{data_sets, stills, cache.path()};
  std::string stored_hash = "hash";
  int woken = 0;
  Anonymise anonymise{
      data_sets, store, thumbnails, placement, clock, signals, [this](const std::string& of) {
        return of == id ? stored_hash : "of another scan";
      }};
};

TEST_F(AnonymiseTest, OnlyTheOwnerAnonymises) {
  expect_permission(Action::kAnonymise,
                    [&](const Principal& who) { return refusal(anonymise.get(who, id)); });
  expect_permission(Action::kAnonymise, [&](const Principal& who) {
    return refusal(anonymise.cut(who, id, "region", "hash"));
  });
  for (const auto& [order, now] : store.orders) EXPECT_EQ(order.asked_by, owner.user_id);
}

TEST_F(AnonymiseTest, TheOwnerSeesTheFactsAndTheHashOfAVolumeThatIsReady) {
  const auto view = anonymise.get(owner, id);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->data_set.id, id);
  EXPECT_EQ(view->facts.head, "head");
  EXPECT_EQ(view->facts.problem, "problem");
  EXPECT_EQ(view->volume_hash, "hash");
  scan().state = DataSetState::kQueued;
  EXPECT_EQ(anonymise.get(owner, id)->volume_hash, "") << "it is about to change";
}

TEST_F(AnonymiseTest, AScanThatIsNotReadyIsNotAnonymised) {
  for (const auto state : {DataSetState::kUploading, DataSetState::kQueued, DataSetState::kBuilding,
                           DataSetState::kRefused, DataSetState::kExpired}) {
    scan().state = state;
    const auto refused = anonymise.cut(owner, id, "region", "");
    ASSERT_EQ(refusal(refused), ProblemKind::kNotReady);
    EXPECT_THAT(refused.error().detail, HasSubstr(to_string(state)));
  }
  EXPECT_THAT(store.orders, IsEmpty());
}

TEST_F(AnonymiseTest, OnlyTheVolumeThatTheOwnerReviewedIsAnonymised) {
  EXPECT_EQ(cut("hash of an older volume"), ProblemKind::kPrecondition);
  EXPECT_EQ(cut(""), ProblemKind::kPrecondition);
  EXPECT_THAT(store.orders, IsEmpty());
  EXPECT_THAT(placement.ended, IsEmpty());
  EXPECT_EQ(woken, 0);
}

TEST_F(AnonymiseTest, AnOrderHasTheRegionAndTheReviewedVolume) {
  EXPECT_EQ(cut(), Refusal());
  ASSERT_EQ(store.orders.size(), 1u);
  const auto& [order, now] = store.orders[0];
  EXPECT_EQ(order.data_set_id, id);
  EXPECT_EQ(order.region, "region");
  EXPECT_EQ(order.volume_hash, "hash");
  EXPECT_EQ(order.asked_by, owner.user_id);
  EXPECT_EQ(now, clock.wall());
}

TEST_F(AnonymiseTest, NothingShowsTheOldVoxelsAfterwards) {
  ASSERT_TRUE(thumbnails.get(owner, id, "bone"));
  store.before("order", [&] { scan().state = DataSetState::kQueued; });
  const auto view = anonymise.cut(owner, id, "region", "hash");
  ASSERT_TRUE(view);
  EXPECT_EQ(view->data_set.state, DataSetState::kQueued);
  EXPECT_EQ(view->volume_hash, "");
  EXPECT_THAT(placement.ended, ElementsAre("of " + id));
  EXPECT_FALSE(cache.has("thumbnails/" + id));
  EXPECT_EQ(woken, 1);
}

TEST_F(AnonymiseTest, AnOrderIsCarriedOutWithoutTheSessionDirectory) {
  placement.away = true;
  EXPECT_EQ(cut(), Refusal());
  EXPECT_EQ(woken, 1);
}

TEST_F(AnonymiseTest, TheSecondOfTwoOrdersAtATimeIsRefused) {
  store.break_function("order", ErrorCode::kConflict);
  EXPECT_EQ(cut(), ProblemKind::kNotReady);
  EXPECT_THAT(placement.ended, IsEmpty());
  store.break_function("facts", ErrorCode::kNotFound);
  EXPECT_EQ(cut(), ProblemKind::kNotFound);
}

TEST_F(AnonymiseTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {data_set_store, "find", [&] { return refusal(anonymise.get(owner, id)); }},
      {store, "facts", [&] { return refusal(anonymise.get(owner, id)); }},
      {store, "facts", [&] { return cut(); }},
      {store, "order", [&] { return cut(); }},
  });
  EXPECT_THAT(placement.ended, IsEmpty());
}

}  // namespace
}  // namespace diaphane::api
