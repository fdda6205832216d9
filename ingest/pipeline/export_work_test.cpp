#include "ingest/pipeline/export_work.h"

#include <gtest/gtest.h>

#include <deque>
#include <filesystem>
#include <fstream>

#include "common/ids.h"
#include "volume/volume.h"

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;

/// A queue in memory that records its calls.
class FakeExports final : public ExportJobs {
 public:
  Result<std::optional<ExportJob>> claim() override {
    if (waiting.empty()) return std::optional<ExportJob>();
    const ExportJob job = waiting.front();
    waiting.pop_front();
    return std::optional<ExportJob>(job);
  }
  Result<bool> renew(const ExportJob&) override { return held && renewals-- > 0; }
  Result<bool> finish(const ExportJob&, std::uint64_t bytes) override {
    if (!held || gone_at_finish) return false;
    ready.push_back(bytes);
    return true;
  }
  Result<void> fail_with(const ExportJob&, const std::string& code,
                         const std::string& text) override {
    failures.push_back(code);
    told = text;
    return {};
  }
  struct PutBack {
    std::chrono::milliseconds pause;
    bool waiting, counted;
    bool operator==(const PutBack&) const = default;
  };
  Result<void> put_back(const ExportJob&, std::chrono::milliseconds pause, bool waits,
                        bool count_attempt) override {
    put_backs.push_back({pause, waits, count_attempt});
    return {};
  }

  std::deque<ExportJob> waiting;
  bool held = true, gone_at_finish = false;
  int renewals = 100;  ///< that succeed
  std::string told;
  std::vector<std::uint64_t> ready;
  std::vector<std::string> failures;
  std::vector<PutBack> put_backs;
};

class ExportWorkerTest : public testing::Test {
 protected:
  ExportWorkerTest() {
    std::string name = (fs::temp_directory_path() / "exports-XXXXXX").string();
    root = mkdtemp(name.data());
    volume::Volume scan;
    scan.header.size = {8, 8, 8};
    scan.voxels.resize(512);
    volume::measure(scan);
    EXPECT_TRUE(volume::write(scan, root + "/" + job.data_set_id));
  }
  ~ExportWorkerTest() override { fs::remove_all(root); }

  /// Makes one export with this result.
  void work(Result<Build> result, bool stopping = false) {
    jobs.waiting.push_back(job);
    ExportWorker worker({.volume_dir = root, .export_dir = root + "/exports", .renew = {}}, jobs,
                        [&](const ExportInput& input,
                            const Builder::ShouldContinue& should_continue) -> Result<Build> {
                          input_seen = input;
                          std::ofstream(input.path) << "file";
                          continued = should_continue();
                          return result;
                        });
    EXPECT_TRUE(worker.work_once([&] { return stopping; }));
    EXPECT_FALSE(worker.work_once([] { return false; }));
  }
  static Build done() {
    Build build;
    build.verdict.ready = true;
    build.written = 4;
    return build;
  }
  bool has_file() const { return fs::exists(root + "/exports/" + job.id + ".scan"); }
  bool has_rest() const {
    for (const auto& entry : fs::directory_iterator(root + "/exports")) {
      if (entry.path().filename().string().starts_with(".tmp-")) return true;
    }
    return false;
  }

  ExportJob job{.id = new_id(), .data_set_id = new_id(), .order = {ExportFormat::kStl, {}, 5}};
  FakeExports jobs;
  std::string root;
  ExportInput input_seen;
  bool continued = false;
};

TEST_F(ExportWorkerTest, LeavesTheFileUnderItsIdAndReportsItsSize) {
  work(done());
  EXPECT_TRUE(has_file());
  EXPECT_FALSE(has_rest());
  EXPECT_TRUE(continued);
  EXPECT_EQ(jobs.ready, std::vector<std::uint64_t>{4});
  EXPECT_EQ(input_seen.order.above, 5);
  EXPECT_EQ(input_seen.header.size, (std::array<std::uint32_t, 3>{8, 8, 8}));
}

TEST_F(ExportWorkerTest, RemovesTheFileOfAnExportThatWasDeletedMeanwhile) {
  jobs.held = false;
  work(done());
  EXPECT_FALSE(continued);
  EXPECT_FALSE(has_file());
  EXPECT_FALSE(has_rest());
  EXPECT_TRUE(jobs.ready.empty() && jobs.failures.empty() && jobs.put_backs.empty());
}

TEST_F(ExportWorkerTest, GivesTheReasonOfARefusal) {
  Build build;
  build.verdict = refused("nothing_inside", "No.");
  work(build);
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"nothing_inside"});
  EXPECT_FALSE(has_rest());
}

TEST_F(ExportWorkerTest, SpeaksOfTheExportInsteadOfAnUpload) {
  for (const auto& [child, told] :
       {std::pair{"too_slow", "too_slow"}, std::pair{"unreadable", "internal"}}) {
    jobs.failures.clear();
    Build build;
    build.verdict = refused(child, "This upload is wrong.");
    work(build);
    EXPECT_EQ(jobs.failures, std::vector<std::string>{told});
    EXPECT_EQ(jobs.told.find("upload"), std::string::npos) << jobs.told;
  }
}

TEST_F(ExportWorkerTest, GivesUpAFileWhoseCopyWasStopped) {
  Build build = done();
  build.stopped = true;
  work(build, true);
  EXPECT_FALSE(has_file());
  EXPECT_FALSE(has_rest());
  const FakeExports::PutBack expected{{}, false, false};
  EXPECT_EQ(jobs.put_backs, std::vector{expected});
}

TEST_F(ExportWorkerTest, KeepsTheFileOfTheNextWorkerAfterItLostItsLease) {
  jobs.renewals = 1;
  fs::create_directories(root + "/exports");
  std::ofstream(root + "/exports/" + job.id + ".scan") << "of the next worker";
  work(done());
  EXPECT_TRUE(continued);
  EXPECT_TRUE(has_file());
  EXPECT_FALSE(has_rest());
  EXPECT_TRUE(jobs.ready.empty());
}

TEST_F(ExportWorkerTest, RemovesTheFileOfAScanThatChangedWhileItWasFinished) {
  jobs.gone_at_finish = true;
  work(done());
  EXPECT_FALSE(has_file());
  EXPECT_FALSE(has_rest());
}

TEST_F(ExportWorkerTest, WaitsLongerEachTimeForAConditionToPass) {
  for (const auto& [waits, seconds] : {std::pair{0, 1}, std::pair{3, 8}, std::pair{40, 60}}) {
    jobs.put_backs.clear();
    job.waits = waits;
    work(fail(ErrorCode::kTooLarge, "the disk is full"));
    const FakeExports::PutBack expected{std::chrono::seconds(seconds), true, false};
    EXPECT_EQ(jobs.put_backs, std::vector{expected});
    EXPECT_FALSE(has_rest());
  }
}

TEST_F(ExportWorkerTest, CountsAttemptsForWhichMemoryWasShort) {
  Build build;
  build.killed = true;
  work(build);
  ASSERT_EQ(jobs.put_backs.size(), 1U);
  EXPECT_TRUE(jobs.put_backs[0].counted);
  job.attempts = 3;
  std::ofstream(root + "/exports/.tmp-" + job.id + "-" + new_id()) << "of a killed worker";
  work(done());
  EXPECT_FALSE(has_rest());
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"no_memory"});
  EXPECT_FALSE(has_file());
}

TEST_F(ExportWorkerTest, GivesTheExportBackWhenItStops) {
  Build build;
  build.stopped = true;
  work(build, true);
  EXPECT_FALSE(continued);
  const FakeExports::PutBack expected{{}, false, false};
  EXPECT_EQ(jobs.put_backs, std::vector{expected});
}

TEST_F(ExportWorkerTest, FailsWithoutAVolume) {
  job.data_set_id = new_id();
  work(done());
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"internal"});
}

TEST(ExportOrder, SurvivesItsText) {
  for (const ExportOrder& order : {ExportOrder{ExportFormat::kNiftiGz, {}, {}},
                                   ExportOrder{ExportFormat::kStl, 4294967044U, {}},
                                   ExportOrder{ExportFormat::kGlb, {}, -300, 7}}) {
    const auto read = export_order_of(to_text(order));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->format, order.format);
    EXPECT_EQ(read->label, order.label);
    EXPECT_EQ(read->above, order.above);
    EXPECT_EQ(read->phase, order.phase);
  }
  EXPECT_FALSE(export_order_of("{}"));
  EXPECT_FALSE(export_order_of(R"({"format":"obj"})"));
}

}  // namespace
}  // namespace diaphane::ingest
