#include "api/sharing/reports.h"

#include <gmock/gmock.h>

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_preset_store.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// Keeps reports, and notes each action of an administrator as "<action> <subject> <ID>".
class FakeReportStore final : public ReportStore, public Fake {
 public:
  std::vector<std::pair<Report, std::string>> reports;  ///< with the reporter
  std::vector<std::string> actions;
  std::string reason;
  int limit = 0;
  AuditEntry last;

  Result<void> report(const Report& report, const std::string& reporter_id) override {
    DIAPHANE_TRY(enter("report"));
    reports.emplace_back(report, reporter_id);
    return {};
  }
  Result<std::vector<Report>> open(int most, const AuditEntry& entry, Time) override {
    DIAPHANE_TRY(note("open", entry));
    limit = most;
    return std::vector<Report>(2);
  }
  Result<int> count_open() override {
    DIAPHANE_TRY(enter("count_open"));
    return 4;
  }
  Result<std::vector<TakeDown>> taken_down(int most, const AuditEntry& entry, Time) override {
    DIAPHANE_TRY(note("taken_down", entry));
    limit = most;
    return std::vector<TakeDown>(3);
  }
  Result<void> close(const std::string&, const AuditEntry& entry, Time) override {
    return note("close", entry);
  }
  Result<void> take_down(const std::string&, const std::string& why, const AuditEntry& entry,
                         Time) override {
    reason = why;
    return note("take_down", entry);
  }
  Result<void> restore(const std::string&, const AuditEntry& entry, Time) override {
    return note("restore", entry);
  }
  Result<void> take_down_preset(const std::string&, const std::string& why, const AuditEntry& entry,
                                Time) override {
    reason = why;
    return note("take_down_preset", entry);
  }
  Result<void> restore_preset(const std::string&, const AuditEntry& entry, Time) override {
    return note("restore_preset", entry);
  }

 private:
  Result<void> note(const std::string& function, const AuditEntry& entry) {
    DIAPHANE_TRY(enter(function));
    last = entry;
    actions.push_back(entry.action + " " + entry.subject + " " + entry.subject_id);
    return {};
  }
};

class ReportsTest : public DataSetFixture {
 protected:
  ReportsTest() {
    expose(Exposure::kPublic);
    Preset& preset = preset_store.presets[preset_id];
    preset.id = preset_id;
    preset.data_set_id = id;
    preset.author_id = owner.user_id;
  }

  const std::string preset_id = new_id();
  FakeReportStore store;
  FakePresetStore preset_store;
  Presets presets{data_sets, preset_store, clock, signals};
  std::vector<std::string> ended;  ///< data sets whose lost sessions were ended
  Reports reports{data_sets, presets,
                  store,     accounts,
                  clock,     [this](const std::string& data_set) { ended.push_back(data_set); }};
};

TEST_F(ReportsTest, ReportNamesItsSubjectAndReason) {
  ASSERT_TRUE(reports.report(stranger, id, "identifies", "A name is visible."));
  ASSERT_TRUE(reports.report_preset(stranger, preset_id, "offensive", ""));
  ASSERT_EQ(store.reports.size(), 2u);
  const auto& [of_scan, reporter] = store.reports[0];
  EXPECT_TRUE(is_id(of_scan.id));
  EXPECT_EQ(reporter, stranger.user_id);
  EXPECT_EQ(of_scan.data_set_id, id);
  EXPECT_EQ(of_scan.preset_id, "");
  EXPECT_EQ(of_scan.reason, "identifies");
  EXPECT_EQ(of_scan.words, "A name is visible.");
  EXPECT_EQ(of_scan.created_at, clock.wall());
  EXPECT_EQ(store.reports[1].first.data_set_id, id);
  EXPECT_EQ(store.reports[1].first.preset_id, preset_id);
}

TEST_F(ReportsTest, ReportingNeedsItsPermission) {
  expect_permission(Action::kReport, [&](const Principal& who) {
    accounts.attempts.clear();
    return refusal(reports.report(who, id, "other", ""));
  });
  preset_store.presets[preset_id].author_id = "somebody";
  expect_permission(Action::kReport, [&](const Principal& who) {
    return refusal(reports.report_preset(who, preset_id, "other", ""));
  });
}

TEST_F(ReportsTest, RefusesReportsOfOwnAndInvisiblePresets) {
  preset_store.presets[preset_id].author_id = stranger.user_id;
  EXPECT_EQ(refusal(reports.report_preset(stranger, preset_id, "other", "")),
            ProblemKind::kForbidden);
  preset_store.presets[preset_id].taken_down = true;
  EXPECT_EQ(refusal(reports.report_preset(shared, preset_id, "other", "")), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(reports.report_preset(shared, new_id(), "other", "")), ProblemKind::kNotFound);
  EXPECT_THAT(store.reports, IsEmpty());
}

TEST_F(ReportsTest, LimitsReportsToTwentyPerDay) {
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(reports.report(stranger, id, "other", ""));
    ASSERT_TRUE(reports.report_preset(stranger, preset_id, "other", ""));
  }
  const auto refused = reports.report(stranger, id, "other", "");
  ASSERT_EQ(refusal(refused), ProblemKind::kTooManyAttempts);
  EXPECT_GT(refused.error().retry_after, 0s);
  EXPECT_EQ(refusal(reports.report_preset(stranger, preset_id, "other", "")),
            ProblemKind::kTooManyAttempts);
  EXPECT_EQ(store.reports.size(), 20u);
  EXPECT_TRUE(reports.report(shared, id, "other", "")) << "others have limits of their own";
  clock.advance(24h);
  EXPECT_TRUE(reports.report(stranger, id, "other", ""));
}

TEST_F(ReportsTest, EachActionOfAnAdministratorIsRecordedWithTheirId) {
  const std::string report_id = new_id();
  EXPECT_EQ(reports.open(administrator)->size(), 2u);
  EXPECT_EQ(reports.count_open(), 4);
  EXPECT_EQ(store.limit, 200);
  EXPECT_EQ(reports.taken_down(administrator)->size(), 3u);
  EXPECT_TRUE(reports.close(administrator, report_id));
  EXPECT_TRUE(reports.take_down(administrator, id, "identifies"));
  EXPECT_EQ(store.reason, "identifies");
  EXPECT_TRUE(reports.restore(administrator, id));
  EXPECT_TRUE(reports.take_down_preset(administrator, preset_id, "offensive"));
  EXPECT_EQ(store.reason, "offensive");
  EXPECT_TRUE(reports.restore_preset(administrator, preset_id));
  EXPECT_THAT(
      store.actions,
      ElementsAre("reports.looked-at report ", "reports.looked-at report ",
                  "report.dismissed report " + report_id, "data-set.taken-down data_set " + id,
                  "data-set.restored data_set " + id, "preset.taken-down preset " + preset_id,
                  "preset.restored preset " + preset_id));
  EXPECT_EQ(store.last.actor, AuditActor::kAdministrator);
  EXPECT_EQ(store.last.actor_id, administrator.user_id);
}

TEST_F(ReportsTest, OnlyAdministratorsTakeDownAndRestore) {
  expect_permission(Action::kTakeDown, [&](const Principal& who) {
    return refusal(reports.take_down(who, id, "other"));
  });
  expect_permission(Action::kTakeDown,
                    [&](const Principal& who) { return refusal(reports.restore(who, id)); });
  expect_permission(Action::kTakeDown, [&](const Principal& who) {
    return refusal(reports.take_down_preset(who, preset_id, "other"));
  });
  expect_permission(Action::kTakeDown, [&](const Principal& who) {
    return refusal(reports.restore_preset(who, preset_id));
  });
}

TEST_F(ReportsTest, TakingDownAScanEndsTheSessionsOfThoseWhoLostIt) {
  EXPECT_FALSE(reports.take_down(stranger, id, "other"));
  EXPECT_THAT(ended, IsEmpty());
  EXPECT_TRUE(reports.take_down(administrator, id, "other"));
  EXPECT_THAT(ended, ElementsAre(id));
  EXPECT_TRUE(reports.restore(administrator, id));
  EXPECT_TRUE(reports.take_down_preset(administrator, preset_id, "other"));
  EXPECT_THAT(ended, ElementsAre(id));
}

TEST_F(ReportsTest, MissingReportCannotBeClosed) {
  EXPECT_EQ(refusal(reports.close(administrator, "no id")), ProblemKind::kNotFound);
  EXPECT_THAT(store.actions, IsEmpty());
  store.break_function("close", ErrorCode::kNotFound);
  const auto refused = reports.close(administrator, new_id());
  ASSERT_EQ(refusal(refused), ProblemKind::kNotFound);
  EXPECT_EQ(refused.error().detail, "Report not found.");
}

TEST_F(ReportsTest, MissingPresetCannotBeTakenDown) {
  store.break_function("take_down_preset", ErrorCode::kNotFound);
  store.break_function("restore_preset", ErrorCode::kNotFound);
  EXPECT_EQ(refusal(reports.take_down_preset(administrator, preset_id, "other")),
            ProblemKind::kNotFound);
  EXPECT_EQ(refusal(reports.restore_preset(administrator, preset_id)), ProblemKind::kNotFound);
}

TEST_F(ReportsTest, ReportsAnUnavailableDatabase) {
  const auto report = [&] { return refusal(reports.report(stranger, id, "other", "")); };
  const auto of_preset = [&] {
    return refusal(reports.report_preset(stranger, preset_id, "other", ""));
  };
  const auto take_down = [&] { return refusal(reports.take_down(administrator, id, "other")); };
  const auto restore = [&] { return refusal(reports.restore(administrator, id)); };
  const auto take_down_preset = [&] {
    return refusal(reports.take_down_preset(administrator, preset_id, "other"));
  };
  const auto restore_preset = [&] {
    return refusal(reports.restore_preset(administrator, preset_id));
  };
  expect_unavailable({
      {data_set_store, "find", report},
      {accounts, "note_attempt", report},
      {store, "report", report},
      {preset_store, "find", of_preset},
      {store, "report", of_preset},
      {store, "open", [&] { return refusal(reports.open(administrator)); }},
      {store, "count_open", [&] { return refusal(reports.count_open()); }},
      {store, "close", [&] { return refusal(reports.close(administrator, new_id())); }},
      {store, "take_down", take_down},
      {data_set_store, "find", take_down},
      {store, "restore", restore},
      {data_set_store, "find", restore},
      {store, "take_down_preset", take_down_preset},
      {preset_store, "find", take_down_preset},
      {store, "restore_preset", restore_preset},
      {preset_store, "find", restore_preset},
  });
  EXPECT_THAT(ended, IsEmpty());
}

}  // namespace
}  // namespace diaphane::api
