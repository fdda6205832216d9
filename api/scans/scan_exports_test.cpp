#include "api/scans/scan_exports.h"

#include <gmock/gmock.h>

#include "tests/support/api/data_set_fixture.h"

namespace diaphane::api {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;

class FakeScanExportStore final : public ScanExportStore, public Fake {
 public:
  Result<Request> request(const std::string&, const ScanExport& requested,
                          std::int64_t most_bytes) override {
    DIAPHANE_TRY(enter("request"));
    most = most_bytes;
    if (answer == Request::kMade) kept = requested;
    return answer;
  }
  Result<std::optional<ScanExport>> find(const std::string&, const std::string& id, Time) override {
    DIAPHANE_TRY(enter("find"));
    return kept && kept->data_set_id == id ? kept : std::nullopt;
  }
  Result<bool> remove(const std::string&, const std::string&) override {
    DIAPHANE_TRY(enter("remove"));
    const bool had = kept.has_value();
    kept.reset();
    return had;
  }
  Result<void> expire(Time) override { return {}; }

  Request answer = Request::kMade;
  std::optional<ScanExport> kept;
  std::int64_t most = 0;
};

class ScanExportsTest : public DataSetFixture {
 protected:
  Refusal ask(const Principal& who) {
    return refusal(exports.request(who, id, {"stl", std::nullopt, 300}));
  }
  void make_ready(const std::string& format = "nifti") {
    ASSERT_TRUE(exports.request(owner, id, {format, {}, {}}));
    store.kept->state = "ready";
  }

  FakeScanExportStore store;
  ScanExports exports{data_sets, store, clock, signals, 1000};
};

TEST_F(ScanExportsTest, AreOnlyForTheOwner) {
  make_ready();
  expect_permission(Action::kExport, [&](const Principal& who) { return ask(who); });
  expect_permission(Action::kExport,
                    [&](const Principal& who) { return refusal(exports.find(who, id)); });
  store.kept->state = "ready";
  expect_permission(Action::kExport,
                    [&](const Principal& who) { return refusal(exports.file(who, id)); });
  // No permission to see slices or to save videos includes the file.
  scan().to_person = scan().to_public = {true, true};
  EXPECT_EQ(ask(shared), ProblemKind::kForbidden);
  EXPECT_EQ(refusal(exports.file(shared, id)), ProblemKind::kForbidden);
  EXPECT_EQ(refusal(exports.remove(shared, id)), ProblemKind::kForbidden);
}

TEST_F(ScanExportsTest, OfAScanThatIsNotReadyAreRefused) {
  scan().state = DataSetState::kBuilding;
  EXPECT_EQ(ask(owner), ProblemKind::kNotReady);
}

TEST_F(ScanExportsTest, HaveLimits) {
  store.answer = ScanExportStore::Request::kBusy;
  EXPECT_EQ(ask(owner), ProblemKind::kTooMany);
  store.answer = ScanExportStore::Request::kFull;
  EXPECT_EQ(ask(owner), ProblemKind::kStorageFull);
  store.answer = ScanExportStore::Request::kNotReady;
  EXPECT_EQ(ask(owner), ProblemKind::kNotReady);
  EXPECT_EQ(store.most, 1000);
}

TEST_F(ScanExportsTest, AreDownloadedOnlyOnceTheyAreReady) {
  EXPECT_EQ(refusal(exports.file(owner, id)), ProblemKind::kNotFound);
  EXPECT_EQ(ask(owner), Refusal());
  EXPECT_EQ(refusal(exports.file(owner, id)), ProblemKind::kNotReady);
  for (const auto& [format, name] :
       {std::pair{"nifti", "scan.nii.gz"}, std::pair{"stl", "surface.stl"},
        std::pair{"glb", "surface.glb"}}) {
    make_ready(format);
    const auto file = exports.file(owner, id);
    ASSERT_TRUE(file);
    EXPECT_EQ(file->stored, store.kept->id + ".scan");
    EXPECT_EQ(file->name, name);
  }
}

TEST_F(ScanExportsTest, TellTheAuditLogEachFormat) {
  for (const char* format : {"nifti", "stl"}) {
    make_ready(format);
    ASSERT_TRUE(exports.file(owner, id));
    EXPECT_THAT(
        data_set_store.accesses,
        Contains(AllOf(Field(&AuditEntry::action, "data-set.export-downloaded"),
                       Field(&AuditEntry::details, Contains(AuditDetail{"format", format})))));
  }
}

TEST_F(ScanExportsTest, AreFoundAndRemoved) {
  make_ready();
  EXPECT_EQ(refusal(exports.find(owner, add_scan())), ProblemKind::kNotFound);
  int woken = 0;
  signals.subscribe(Signal::kDisposal, [&] { ++woken; });
  EXPECT_TRUE(exports.find(owner, id));
  EXPECT_TRUE(exports.remove(owner, id));
  EXPECT_EQ(woken, 1);
  EXPECT_EQ(refusal(exports.remove(owner, id)), ProblemKind::kNotFound);
}

TEST_F(ScanExportsTest, SayWhenTheDatabaseIsUnavailable) {
  make_ready();
  for (const char* function : {"request", "find", "remove"}) {
    store.break_function(function);
    const std::string broken = function;
    EXPECT_EQ(broken == "request" ? ask(owner)
              : broken == "find"  ? refusal(exports.file(owner, id))
                                  : refusal(exports.remove(owner, id)),
              ProblemKind::kUnavailable);
  }
}

}  // namespace
}  // namespace diaphane::api
