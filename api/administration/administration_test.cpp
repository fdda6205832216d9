#include "api/administration/administration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/ids.h"
#include "tests/support/api/fake_placement.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class FakeAdministrationStore final : public AdministrationStore, public Fake {
 public:
  std::vector<UserRecord> accounts;
  std::vector<AuditRecord> records;
  std::vector<std::pair<AuditEntry, Time>> notes;
  std::vector<std::string> data_sets;
  std::string changed_by;
  AuditFilter filter;

  Result<std::vector<UserRecord>> users(const std::string& part, const std::optional<Cursor>&,
                                        int limit, Time) override {
    DIAPHANE_TRY(enter("users"));
    std::vector<UserRecord> found;
    for (const UserRecord& one : accounts) {
      const bool matches = one.email.find(part) != std::string::npos;
      if (matches && static_cast<int>(found.size()) < limit) found.push_back(one);
    }
    return found;
  }
  Result<std::optional<UserRecord>> user(const std::string& id, Time) override {
    DIAPHANE_TRY(enter("user"));
    for (const UserRecord& one : accounts) {
      if (one.id == id) return one;
    }
    return std::nullopt;
  }
  Result<bool> change(const std::string& administrator_id, const std::string& id,
                      const UserChange& change, Time) override {
    DIAPHANE_TRY(enter("change"));
    changed_by = administrator_id;
    for (UserRecord& one : accounts) {
      if (one.id != id) continue;
      one.disabled = change.disabled.value_or(one.disabled);
      one.storage.bytes = change.quota_bytes.value_or(one.storage.bytes);
      return true;
    }
    return false;
  }
  Result<bool> set_administrator(const std::string&, bool, Time) override { return true; }
  Result<std::vector<Administrator>> administrators() override {
    return std::vector<Administrator>();
  }
  Result<void> note(const AuditEntry& entry, Time now) override {
    DIAPHANE_TRY(enter("note"));
    notes.emplace_back(entry, now);
    return {};
  }
  Result<std::vector<AuditRecord>> audit(const AuditFilter& asked) override {
    DIAPHANE_TRY(enter("audit"));
    filter = asked;
    auto page = records;
    if (static_cast<int>(page.size()) > asked.limit) page.resize(std::size_t(asked.limit));
    return page;
  }
  Result<IngestQueue> ingest_queue() override {
    DIAPHANE_TRY(enter("ingest_queue"));
    return IngestQueue{3, 1};
  }
  Result<std::vector<std::string>> ready_data_sets(const std::string&) override {
    DIAPHANE_TRY(enter("ready_data_sets"));
    return data_sets;
  }
};

class FakeWorkers final : public Workers, public Fake {
 public:
  Result<std::vector<WorkerInfo>> alive() override {
    DIAPHANE_TRY(enter("alive"));
    WorkerInfo worker;
    worker.id = "worker";
    return std::vector{worker};
  }
  Result<bool> lost(std::string_view, std::string_view) override { return false; }
};

class AdministrationTest : public testing::Test {
 protected:
  AdministrationTest() {
    root.user_id = new_id();
    root.administrator = true;
    for (int i = 0; i < 3; ++i) {
      UserRecord user;
      user.id = new_id();
      user.email = "user" + std::to_string(i) + "@example.org";
      user.created_at = clock.wall() - i * 1h;
      store.accounts.push_back(user);
    }
  }
  const std::string& first() const { return store.accounts[0].id; }
  Outcome<UserRecord> disable(const std::string& id, bool disabled = true) {
    UserChange change;
    change.disabled = disabled;
    return administration.change(root, id, change);
  }
  /// Expects one audit entry about a look by `root`, and removes it.
  void expect_noted(const std::string& action, const std::string& subject,
                    const std::string& subject_id, const std::string& details) {
    ASSERT_EQ(store.notes.size(), 1u);
    const auto& [entry, now] = store.notes[0];
    EXPECT_EQ(entry.actor, AuditActor::kAdministrator);
    EXPECT_EQ(entry.actor_id, root.user_id);
    EXPECT_EQ(entry.action, action);
    EXPECT_EQ(entry.subject, subject);
    EXPECT_EQ(entry.subject_id, subject_id);
    EXPECT_EQ(details_as_json(entry.details), details);
    EXPECT_EQ(now, clock.wall());
    store.notes.clear();
  }

  Principal root;
  ManualClock clock;
  FakeAdministrationStore store;
  FakePlacement placement;
  FakeWorkers workers;
  Administration administration{store, placement, workers, clock};
};

TEST_F(AdministrationTest, APageOfAccountsEndsWithACursorOnlyIfThereIsMore) {
  const auto all = administration.users(root, "", {}, 3);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->items.size(), 3u);
  EXPECT_FALSE(all->next);
  const auto some = administration.users(root, "", {}, 2);
  EXPECT_EQ(some->items.size(), 2u);
  const auto last = (clock.wall() - 1h).time_since_epoch() / 1us;
  EXPECT_EQ(some->next, (Cursor{last, store.accounts[1].id}));
}

TEST_F(AdministrationTest, RecordsEachViewOfUserData) {
  ASSERT_TRUE(administration.users(root, "user1", {}, 3));
  expect_noted("accounts.looked-at", "account", "", R"({"items":1})");
  ASSERT_TRUE(administration.user(root, first()));
  expect_noted("account.looked-at", "account", first(), "{}");
  store.records.resize(2);
  ASSERT_TRUE(administration.audit(root, {}));
  expect_noted("audit-log.looked-at", "audit_log", "", R"({"items":2})");
  ASSERT_TRUE(administration.audit(root, {.account_id = first(), .limit = 1}));
  expect_noted("audit-log.looked-at", "audit_log", "",
               R"({"items":1,"account":")" + first() + R"("})");
}

TEST_F(AdministrationTest, ShowsNoDataIfTheViewCannotBeRecorded) {
  expect_unavailable({
      {store, "note", [&] { return refusal(administration.users(root, "", {}, 3)); }},
      {store, "note", [&] { return refusal(administration.user(root, first())); }},
      {store, "note", [&] { return refusal(administration.audit(root, {})); }},
  });
}

TEST_F(AdministrationTest, AMissingAccountIsNotFoundAndNotRecorded) {
  EXPECT_EQ(administration.user(root, first())->email, "user0@example.org");
  store.notes.clear();
  for (const std::string& none : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(administration.user(root, none)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(administration.change(root, none, {})), ProblemKind::kNotFound);
  }
  EXPECT_EQ(store.calls("change"), 1) << "the store is asked only for IDs";
  EXPECT_THAT(store.notes, IsEmpty());
}

TEST_F(AdministrationTest, RecordsChangesWithTheAdministrator) {
  UserChange change;
  change.quota_bytes = 5;
  const auto changed = administration.change(root, first(), change);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->storage.bytes, 5);
  EXPECT_FALSE(changed->disabled);
  EXPECT_EQ(store.changed_by, root.user_id);
  EXPECT_THAT(placement.ended, IsEmpty());
}

TEST_F(AdministrationTest, DisablingAnAccountEndsItsSessionsAndThoseOnItsScans) {
  store.data_sets = {"a", "b"};
  EXPECT_TRUE(disable(first())->disabled);
  EXPECT_THAT(placement.ended, UnorderedElementsAre("by " + first(), "of a", "of b"));
  placement.ended.clear();
  EXPECT_FALSE(disable(first(), false)->disabled);
  EXPECT_THAT(placement.ended, IsEmpty());
}

TEST_F(AdministrationTest, AnAccountIsDisabledEvenIfItsSessionsCannotBeEnded) {
  store.data_sets = {"a", "b"};
  placement.break_function("end_all_by");
  EXPECT_TRUE(disable(first()));
  EXPECT_THAT(placement.ended, ElementsAre("of a", "of b"));
  placement.ended.clear();
  placement.repair("end_all_by");
  store.break_function("ready_data_sets");
  EXPECT_TRUE(disable(first()));
  EXPECT_THAT(placement.ended, ElementsAre("by " + first()));
}

TEST_F(AdministrationTest, AdministratorsCannotDisableThemselves) {
  store.accounts[0].id = root.user_id;
  EXPECT_EQ(refusal(disable(root.user_id)), ProblemKind::kConflict);
  EXPECT_EQ(store.calls("change"), 0);
  EXPECT_TRUE(disable(root.user_id, false));
  UserChange change;
  change.quota_bytes = 5;
  EXPECT_TRUE(administration.change(root, root.user_id, change));
}

TEST_F(AdministrationTest, APageOfTheAuditLogEndsWithItsLastEntryOnlyIfThereIsMore) {
  for (const int entry : {9, 7, 4}) {
    store.records.emplace_back();
    store.records.back().id = entry;
  }
  EXPECT_FALSE(administration.audit(root, {.limit = 3})->next);
  const auto some = administration.audit(root, {.action = "account.", .limit = 2});
  EXPECT_EQ(some->items.size(), 2u);
  EXPECT_EQ(some->next, 7);
  EXPECT_EQ(store.filter.action, "account.");
}

TEST_F(AdministrationTest, FleetListsWorkersAndTheQueueOfScans) {
  const auto fleet = administration.fleet();
  ASSERT_TRUE(fleet);
  ASSERT_EQ(fleet->workers.size(), 1u);
  EXPECT_EQ(fleet->workers[0].id, "worker");
  EXPECT_EQ(fleet->ingest.queued, 3);
  EXPECT_EQ(fleet->ingest.building, 1);
}

TEST_F(AdministrationTest, ReportsAnUnavailableStore) {
  expect_unavailable({
      {store, "users", [&] { return refusal(administration.users(root, "", {}, 3)); }},
      {store, "user", [&] { return refusal(administration.user(root, first())); }},
      {store, "change", [&] { return refusal(disable(first())); }},
      {store, "user", [&] { return refusal(disable(first())); }},
      {store, "audit", [&] { return refusal(administration.audit(root, {})); }},
      {workers, "alive", [&] { return refusal(administration.fleet()); }},
      {store, "ingest_queue", [&] { return refusal(administration.fleet()); }},
  });
}

}  // namespace
}  // namespace diaphane::api
