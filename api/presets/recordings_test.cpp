#include "api/presets/recordings.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/ids.h"
#include "common/try.h"
#include "tests/support/api/fake.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

/// Recordings in memory. A user may keep `most_bytes`.
class FakeRecordingStore final : public RecordingStore, public Fake {
 public:
  std::set<std::string> consenting;
  std::map<std::string, std::pair<std::string, Recording>> recordings;  ///< with the user, by ID
  std::int64_t most_bytes = 0;

  Result<bool> consent(const std::string& user_id) override {
    DIAPHANE_TRY(enter("consent"));
    return consenting.contains(user_id);
  }
  Result<void> set_consent(const std::string& user_id, bool given, Time) override {
    DIAPHANE_TRY(enter("set_consent"));
    if (given) consenting.insert(user_id);
    if (!given) consenting.erase(user_id);
    return {};
  }
  Result<void> add(const std::string& user_id, const Recording& recording,
                   std::int64_t most) override {
    DIAPHANE_TRY(enter("add"));
    most_bytes = most;
    if (!consenting.contains(user_id)) return fail(ErrorCode::kForbidden, "no consent");
    if (static_cast<std::int64_t>(recording.body.size()) > most) {
      return fail(ErrorCode::kTooLarge, "too much");
    }
    recordings[recording.id] = {user_id, recording};
    return {};
  }
  Result<std::vector<Recording>> of(const std::string& user_id, Time now) override {
    DIAPHANE_TRY(enter("of"));
    std::vector<Recording> found;
    for (const auto& [id, one] : recordings) {
      if (one.first == user_id && one.second.expires_at > now) found.push_back(one.second);
    }
    return found;
  }
  Result<Recording> find(const std::string& user_id, const std::string& id, Time now) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = recordings.find(id);
    if (found == recordings.end() || found->second.first != user_id ||
        found->second.second.expires_at <= now) {
      return fail(ErrorCode::kNotFound, "no recording");
    }
    return found->second.second;
  }
  Result<void> remove(const std::string& user_id, const std::string& id) override {
    DIAPHANE_TRY(enter("remove"));
    const auto found = recordings.find(id);
    if (found == recordings.end() || found->second.first != user_id) {
      return fail(ErrorCode::kNotFound, "no recording");
    }
    recordings.erase(found);
    return {};
  }
  Result<void> expire(Time) override { return {}; }
};

class RecordingsTest : public testing::Test {
 protected:
  RecordingsTest() {
    anna.user_id = "anna";
    bert.user_id = "bert";
  }
  static Recording of(const std::string& body) {
    Recording recording;
    recording.body = body;
    return recording;
  }

  Principal anna, bert;
  ManualClock clock;
  FakeRecordingStore store;
  Recordings recordings{store, clock};
};

TEST_F(RecordingsTest, NothingIsKeptWithoutConsent) {
  EXPECT_EQ(refusal(recordings.add(anna, of("{}"))), ProblemKind::kForbidden);
  EXPECT_FALSE(recordings.list(anna)->consent);
  ASSERT_TRUE(recordings.give_consent(anna, true));
  EXPECT_TRUE(recordings.list(anna)->consent);
  EXPECT_FALSE(recordings.list(bert)->consent);
  EXPECT_TRUE(recordings.add(anna, of("{}")));
  ASSERT_TRUE(recordings.give_consent(anna, false));
  EXPECT_EQ(refusal(recordings.add(anna, of("{}"))), ProblemKind::kForbidden);
}

TEST_F(RecordingsTest, ARecordingGetsItsOwnIdAndExpiresAfterNinetyDays) {
  ASSERT_TRUE(recordings.give_consent(anna, true));
  Recording given = of("{}");
  given.id = "chosen by the browser";
  const auto id = recordings.add(anna, given);
  ASSERT_TRUE(id);
  EXPECT_TRUE(is_id(*id));
  EXPECT_EQ(recordings.find(anna, *id)->created_at, clock.wall());
  EXPECT_EQ(recordings.find(anna, *id)->body, "{}");
  clock.advance(24h * 90 - 1s);
  EXPECT_EQ(recordings.list(anna)->recordings.size(), 1u);
  clock.advance(1s);
  EXPECT_EQ(recordings.list(anna)->recordings.size(), 0u);
  EXPECT_EQ(refusal(recordings.find(anna, *id)), ProblemKind::kNotFound);
}

TEST_F(RecordingsTest, LimitsRecordingsPerUserToTwentyMebibytes) {
  ASSERT_TRUE(recordings.give_consent(anna, true));
  EXPECT_TRUE(recordings.add(anna, of(std::string(20 * 1024 * 1024, ' '))));
  const auto refused = recordings.add(anna, of(std::string(20 * 1024 * 1024 + 1, ' ')));
  ASSERT_EQ(refusal(refused), ProblemKind::kOverQuota);
  EXPECT_EQ(refused.error().detail, "too much");
}

TEST_F(RecordingsTest, RecordingsOfOthersAreNotFound) {
  ASSERT_TRUE(recordings.give_consent(anna, true));
  const std::string id = recordings.add(anna, of("{}")).value();
  EXPECT_EQ(recordings.list(bert)->recordings.size(), 0u);
  for (const std::string& other : {id, new_id(), std::string("no id")}) {
    EXPECT_EQ(refusal(recordings.find(bert, other)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(recordings.remove(bert, other)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(store.calls("find") + store.calls("remove"), 4) << "the store is asked only for IDs";
  EXPECT_TRUE(recordings.remove(anna, id));
  EXPECT_EQ(refusal(recordings.find(anna, id)), ProblemKind::kNotFound);
}

TEST_F(RecordingsTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {store, "consent", [&] { return refusal(recordings.list(anna)); }},
      {store, "of", [&] { return refusal(recordings.list(anna)); }},
      {store, "set_consent", [&] { return refusal(recordings.give_consent(anna, true)); }},
      {store, "add", [&] { return refusal(recordings.add(anna, of("{}"))); }},
      {store, "find", [&] { return refusal(recordings.find(anna, new_id())); }},
      {store, "remove", [&] { return refusal(recordings.remove(anna, new_id())); }},
  });
}

}  // namespace
}  // namespace diaphane::api
