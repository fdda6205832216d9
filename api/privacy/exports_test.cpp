#include "api/privacy/exports.h"

#include <gmock/gmock.h>

#include <map>

#include "common/try.h"
#include "tests/support/api/fake.h"
#include "tests/support/api/refusals.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

constexpr std::int64_t kGigabyte = 1'000'000'000;

/// Exports in memory: at most one per user.
class FakeExportStore final : public ExportStore, public Fake {
 public:
  std::map<std::string, Export> exports;  ///< by user
  std::vector<Job> due;
  std::map<std::string, Time> waits;  ///< until when, by ID
  std::map<std::string, std::int64_t> finished;
  bool still_wanted = true;
  std::vector<std::string> panoramas;
  Sizes size_of_all;
  std::vector<ExportSection> records{{"records/users.json", "[]"}, {"audit.json", "[1]"}};
  std::vector<std::string> scans;
  std::vector<Picture> images;
  std::vector<std::pair<std::string, std::string>> downloads;  ///< user and address
  std::chrono::seconds lease{0};

  Result<bool> request(const std::string& user_id, const Export& requested,
                       Time not_since) override {
    DIAPHANE_TRY(enter("request"));
    const auto found = exports.find(user_id);
    if (found != exports.end() && found->second.created_at > not_since) return false;
    exports[user_id] = requested;
    return true;
  }
  Result<std::optional<Export>> find(const std::string& user_id, Time now) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = exports.find(user_id);
    if (found == exports.end() || found->second.expires_at <= now) return std::nullopt;
    return found->second;
  }
  Result<bool> remove(const std::string& user_id, Time) override {
    DIAPHANE_TRY(enter("remove"));
    return exports.erase(user_id) > 0;
  }
  Result<std::optional<Job>> claim(Time, std::chrono::seconds time) override {
    DIAPHANE_TRY(enter("claim"));
    lease = time;
    if (due.empty()) return std::nullopt;
    const Job job = due.front();
    due.erase(due.begin());
    return job;
  }
  Result<std::vector<ExportSection>> sections(const std::string&) override {
    DIAPHANE_TRY(enter("sections"));
    return records;
  }
  Result<std::vector<std::string>> volumes(const std::string&) override {
    DIAPHANE_TRY(enter("volumes"));
    return scans;
  }
  Result<std::vector<Picture>> pictures(const std::string&) override {
    DIAPHANE_TRY(enter("pictures"));
    return images;
  }
  Result<std::vector<std::string>> environments(const std::string&) override {
    DIAPHANE_TRY(enter("environments"));
    return panoramas;
  }
  Result<void> note_download(const std::string& user_id, const Client& client, Time) override {
    DIAPHANE_TRY(enter("note_download"));
    downloads.emplace_back(user_id, client.address);
    return {};
  }
  Result<bool> finish(const std::string& id, std::int64_t bytes) override {
    DIAPHANE_TRY(enter("finish"));
    if (still_wanted) finished[id] = bytes;
    return still_wanted;
  }
  Result<Sizes> sizes(const std::string&) override {
    DIAPHANE_TRY(enter("sizes"));
    return size_of_all;
  }
  Result<void> wait(const std::string& id, Time not_before) override {
    DIAPHANE_TRY(enter("wait"));
    waits[id] = not_before;
    return {};
  }
  Result<void> expire(Time) override { return enter("expire"); }
  Result<std::vector<std::string>> ids() override {
    DIAPHANE_TRY(enter("ids"));
    std::vector<std::string> all;
    for (const auto& [user, one] : exports) all.push_back(one.id);
    return all;
  }
};

/// Archives that list their entries, one per line: "<name> <- <source>" for files.
class FakeArchives final : public Fake {
 public:
  Result<std::unique_ptr<ExportFile>> make(const std::string& path) {
    DIAPHANE_TRY(enter("make"));
    return std::make_unique<Archive>(*this, path);
  }

 private:
  class Archive final : public ExportFile {
   public:
    Archive(FakeArchives& all, std::string path) : all_(all), path_(std::move(path)) {}
    Result<void> add(const std::string& name, std::string_view) override {
      DIAPHANE_TRY(all_.enter("add"));
      std::ofstream(path_, std::ios::app) << name << "\n";
      return {};
    }
    Result<void> add_file(const std::string& name, const std::string& source) override {
      DIAPHANE_TRY(all_.enter("add_file"));
      if (!std::filesystem::exists(source)) return fail(ErrorCode::kNotFound, "no file");
      std::ofstream(path_, std::ios::app) << name << " <- " << source << "\n";
      return {};
    }
    Result<std::int64_t> finish() override {
      DIAPHANE_TRY(all_.enter("finish"));
      return 1234;
    }

   private:
    FakeArchives& all_;
    const std::string path_;
  };
};

class ExportsTest : public testing::Test {
 protected:
  ExportsTest() {
    anna.user_id = "anna";
    signals.subscribe(Signal::kExport, [this] { ++woken; });
  }
  /// Queues the export with this ID, with a number of earlier waits, and creates it.
  void poll(int waits = 0) {
    store.exports["anna"].id = id;
    store.due.push_back({id, "anna", waits});
    exports->poll();
  }
  bool is_made() const { return disk.has("exports/" + id + ".zip"); }
  /// Expects that the export waits for two seconds and left no file.
  void expect_waiting() {
    EXPECT_EQ(store.waits[id], clock.wall() + 2s);
    EXPECT_FALSE(is_made());
    EXPECT_FALSE(disk.has("exports/.tmp-" + id));
    store.waits.clear();
  }
  std::unique_ptr<Exports> with(std::int64_t reserve, std::int64_t total) {
    return std::make_unique<Exports>(
        store, [this](const std::string& path) { return archives.make(path); }, clock, signals,
        Exports::Options{disk.path() + "/volumes", disk.path() + "/pictures",
                         disk.path() + "/exports", reserve, total});
  }

  Principal anna;
  const std::string id = new_id();
  const TemporaryDirectory disk;
  ManualClock clock;
  Signals signals;
  FakeExportStore store;
  FakeArchives archives;
  int woken = 0;
  std::unique_ptr<Exports> exports = with(0, 10 * kGigabyte);
};

TEST_F(ExportsTest, AnExportIsKeptForADay) {
  const auto requested = exports->request(anna);
  ASSERT_TRUE(requested);
  EXPECT_TRUE(is_id(requested->id));
  EXPECT_EQ(requested->state, Export::State::kQueued);
  EXPECT_EQ(requested->created_at, clock.wall());
  EXPECT_EQ(woken, 1);
  clock.advance(24h - 1s);
  EXPECT_EQ(exports->find(anna)->id, requested->id);
  clock.advance(1s);
  EXPECT_EQ(refusal(exports->find(anna)), ProblemKind::kNotFound);
}

TEST_F(ExportsTest, LimitsExportsToOnePerTenMinutes) {
  ASSERT_TRUE(exports->request(anna));
  clock.advance(10min - 1s);
  const auto refused = exports->request(anna);
  ASSERT_EQ(refusal(refused), ProblemKind::kTooMany);
  EXPECT_EQ(refused.error().retry_after, 10min);
  EXPECT_EQ(woken, 1);
  clock.advance(1s);
  EXPECT_TRUE(exports->request(anna));
}

TEST_F(ExportsTest, WithoutAnExportThereIsNothingToGetOrRemove) {
  EXPECT_EQ(refusal(exports->find(anna)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(exports->file(anna)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(exports->remove(anna)), ProblemKind::kNotFound);
  ASSERT_TRUE(exports->request(anna));
  Principal bert;
  bert.user_id = "bert";
  EXPECT_EQ(refusal(exports->find(bert)), ProblemKind::kNotFound);
  int disposals = 0;
  signals.subscribe(Signal::kDisposal, [&] { ++disposals; });
  EXPECT_TRUE(exports->remove(anna));
  EXPECT_EQ(refusal(exports->find(anna)), ProblemKind::kNotFound);
  EXPECT_EQ(disposals, 1) << "its file goes at once";
}

TEST_F(ExportsTest, OnlyAnExportThatIsReadyHasAFile) {
  const auto requested = exports->request(anna);
  for (const auto state : {Export::State::kQueued, Export::State::kFailed}) {
    store.exports["anna"].state = state;
    EXPECT_EQ(refusal(exports->file(anna)), ProblemKind::kNotReady);
  }
  store.exports["anna"].state = Export::State::kReady;
  EXPECT_TRUE(store.downloads.empty());
  EXPECT_EQ(exports->file(anna).value(), requested->id + ".zip");
}

TEST_F(ExportsTest, ADownloadIsRecordedBeforeTheFileIsSent) {
  ASSERT_TRUE(exports->request(anna));
  store.exports["anna"].state = Export::State::kReady;
  Principal who = anna;
  who.client.address = "203.0.113.77";
  ASSERT_TRUE(exports->file(who));
  EXPECT_EQ(store.downloads,
            (std::vector<std::pair<std::string, std::string>>{{"anna", "203.0.113.77"}}));
  store.break_function("note_download");
  EXPECT_EQ(refusal(exports->file(who)), ProblemKind::kUnavailable);
}

TEST_F(ExportsTest, AnExportHasTheRecordsTheVolumesAndTheImagesOfAUser) {
  disk.write("volumes/a/volume.json", "{}");
  disk.write("volumes/a/voxels.i16", "..");
  disk.write("pictures/p/picture.jpg", "image");
  store.scans = {"a"};
  store.images = {{"a", "p"}};
  poll();
  ASSERT_TRUE(is_made());
  EXPECT_EQ(disk.read("exports/" + id + ".zip"),
            "README.txt\nrecords/users.json\naudit.json\n"
            "scans/a/volume.json <- " +
                disk.path() +
                "/volumes/a/volume.json\n"
                "scans/a/voxels.i16 <- " +
                disk.path() +
                "/volumes/a/voxels.i16\n"
                "scans/a/presets/p.jpg <- " +
                disk.path() + "/pictures/p/picture.jpg\n");
  EXPECT_EQ(store.finished[id], 1234);
  EXPECT_EQ(store.lease, 30min);
  EXPECT_FALSE(disk.has("exports/.tmp-" + id));
}

TEST_F(ExportsTest, OmitsDataDeletedMeanwhile) {
  disk.write("volumes/kept/volume.json", "{}");
  store.scans = {"deleted", "kept"};
  store.images = {{"kept", "deleted"}};
  poll();
  EXPECT_EQ(disk.read("exports/" + id + ".zip"),
            "README.txt\nrecords/users.json\naudit.json\n"
            "scans/kept/volume.json <- " +
                disk.path() + "/volumes/kept/volume.json\n");
}

TEST_F(ExportsTest, AllDueExportsAreCreatedAndOldOnesDeleted) {
  const std::string broken = new_id();
  store.due = {{broken, "bert", 0}};
  archives.before("make", [&] {
    archives.repair("add");
    if (archives.calls("make") == 1) archives.break_function("add", ErrorCode::kInternal);
  });
  poll();
  EXPECT_TRUE(is_made()) << "one that fails does not hold up the next";
  EXPECT_FALSE(store.finished.contains(broken));
  EXPECT_EQ(store.calls("expire"), 1);
}

TEST_F(ExportsTest, TransientFailureIsRetriedAndLeavesNoFile) {
  for (const char* step : {"sizes", "sections", "volumes", "environments", "pictures", "finish"}) {
    SCOPED_TRACE(step);
    store.break_function(step);
    poll();
    store.repair(step);
    expect_waiting();
  }
  store.scans = {"a"};
  for (const char* step : {"make", "add", "add_file", "finish"}) {
    SCOPED_TRACE(step);
    archives.break_function(step);
    poll();
    archives.repair(step);
    expect_waiting();
  }
  EXPECT_THAT(store.finished, IsEmpty());
}

TEST_F(ExportsTest, AnExportThatMayBeReadyKeepsItsFile) {
  store.break_function("finish", ErrorCode::kOutcomeUnknown);
  poll();
  EXPECT_TRUE(is_made());
  EXPECT_EQ(store.waits[id], clock.wall() + 2s) << "the store ignores this if it is ready";
}

TEST_F(ExportsTest, FilesWithoutAnExportAreDeleted) {
  const std::string orphan = new_id(), kept = new_id();
  const std::string of_scan = ".tmp-" + orphan + "-" + new_id();
  for (const auto& name :
       {orphan + ".zip", ".tmp-" + orphan, of_scan, kept + ".zip", std::string("other")}) {
    disk.write("exports/" + name, "..");
  }
  store.exports["bert"].id = kept;
  store.break_function("ids");
  exports->poll();
  EXPECT_TRUE(disk.has("exports/" + orphan + ".zip")) << "nothing is known about it";
  store.repair("ids");
  exports->poll();
  EXPECT_FALSE(disk.has("exports/" + orphan + ".zip"));
  EXPECT_FALSE(disk.has("exports/.tmp-" + orphan));
  EXPECT_FALSE(disk.has("exports/" + of_scan));
  EXPECT_TRUE(disk.has("exports/" + kept + ".zip"));
  EXPECT_TRUE(disk.has("exports/other"));
}

TEST_F(ExportsTest, PermanentFailureIsNotRetried) {
  archives.break_function("add", ErrorCode::kInternal);
  poll();
  EXPECT_THAT(store.waits, IsEmpty()) << "the lease and the number of attempts decide";
  EXPECT_FALSE(is_made());
}

TEST_F(ExportsTest, EachWaitIsTwiceAsLongUpToTwoMinutes) {
  store.break_function("sizes");
  for (const auto& [waits, pause] : {std::pair(0, 2s), std::pair(1, 4s), std::pair(5, 64s),
                                     std::pair(6, 120s), std::pair(1000, 120s)}) {
    poll(waits);
    EXPECT_EQ(store.waits[id], clock.wall() + pause) << waits;
  }
}

TEST_F(ExportsTest, AnExportWaitsForRoomOnTheDisk) {
  store.size_of_all.volumes = std::int64_t{1} << 60;
  poll();
  expect_waiting();
  store.size_of_all.volumes = 0;
  exports = with(std::int64_t{1} << 60, 10 * kGigabyte);
  poll();
  expect_waiting();
  EXPECT_EQ(archives.calls("make"), 0);
}

TEST_F(ExportsTest, ExportWaitsForOthersButMayExceedTheLimitAlone) {
  exports = with(-(std::int64_t{1} << 60), 10 * kGigabyte);
  store.size_of_all = {.volumes = 4 * kGigabyte, .kept = 6 * kGigabyte + 1};
  poll();
  expect_waiting();
  store.size_of_all.kept = 6 * kGigabyte;
  poll();
  EXPECT_TRUE(is_made());
  std::filesystem::remove(disk.path() + "/exports/" + id + ".zip");
  store.size_of_all = {.volumes = 11 * kGigabyte, .kept = 0};
  poll();
  EXPECT_TRUE(is_made());
}

TEST_F(ExportsTest, CancelledExportLeavesNoFile) {
  store.still_wanted = false;
  poll();
  EXPECT_FALSE(is_made());
  EXPECT_THAT(store.waits, IsEmpty());
}

TEST_F(ExportsTest, AnExportWaitsForItsDirectory) {
  disk.write("exports", "a file where the directory belongs");
  poll();
  EXPECT_EQ(store.waits[id], clock.wall() + 2s);
}

TEST_F(ExportsTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {store, "request", [&] { return refusal(exports->request(anna)); }},
      {store, "find", [&] { return refusal(exports->find(anna)); }},
      {store, "find", [&] { return refusal(exports->file(anna)); }},
      {store, "remove", [&] { return refusal(exports->remove(anna)); }},
  });
  EXPECT_EQ(woken, 0);
  store.break_function("claim");
  poll();
  EXPECT_EQ(archives.calls("make"), 0);
}

}  // namespace
}  // namespace diaphane::api
