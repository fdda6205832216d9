#include "ingest/pipeline/align_work.h"

#include <gtest/gtest.h>

#include <deque>
#include <filesystem>
#include <limits>

#include "common/ids.h"
#include "ingest/pipeline/align_child.h"
#include "volume/volume.h"

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;

/// A queue in memory that records its calls.
class FakeAlignments final : public AlignJobs {
 public:
  Result<std::optional<AlignJob>> claim() override {
    if (waiting.empty()) return std::optional<AlignJob>();
    const AlignJob job = waiting.front();
    waiting.pop_front();
    return std::optional<AlignJob>(job);
  }
  Result<bool> renew(const AlignJob&) override { return held; }
  Result<bool> finish(const AlignJob&, const RigidAlignment& found) override {
    ready.push_back(found.residual_mm);
    return true;
  }
  Result<void> fail_with(const AlignJob&, const std::string& reason) override {
    failures.push_back(reason);
    return {};
  }
  struct PutBack {
    std::chrono::milliseconds pause;
    bool waiting, counted;
    bool operator==(const PutBack&) const = default;
  };
  Result<void> put_back(const AlignJob&, std::chrono::milliseconds pause, bool waits,
                        bool count_attempt) override {
    put_backs.push_back({pause, waits, count_attempt});
    return {};
  }

  std::deque<AlignJob> waiting;
  bool held = true;
  std::vector<double> ready;
  std::vector<std::string> failures;
  std::vector<PutBack> put_backs;
};

class AlignWorkerTest : public testing::Test {
 protected:
  AlignWorkerTest() {
    std::string name = (fs::temp_directory_path() / "alignments-XXXXXX").string();
    root = mkdtemp(name.data());
    for (const std::string& id : {job.moving, job.fixed}) {
      volume::Volume scan;
      scan.header.size = {8, 8, id == job.fixed ? 9U : 8U};
      scan.voxels.resize(scan.header.voxel_count());
      volume::measure(scan);
      EXPECT_TRUE(volume::write(scan, root + "/" + id));
    }
  }
  ~AlignWorkerTest() override { fs::remove_all(root); }

  /// Makes one alignment with this result.
  void work(Result<Build> result) {
    jobs.waiting.push_back(job);
    AlignWorker worker({.volume_dir = root, .renew = {}}, jobs,
                       [&](const AlignInput& input,
                           const Builder::ShouldContinue& should_continue) -> Result<Build> {
                         inputs.push_back(input);
                         continued = should_continue();
                         return result;
                       });
    EXPECT_TRUE(worker.work_once([] { return false; }));
    EXPECT_FALSE(worker.work_once([] { return false; }));
  }
  static Build done() {
    Build build;
    build.verdict.ready = true;
    build.aligned = RigidAlignment{.residual_mm = 0.75, .overlap = 0.5};
    return build;
  }

  AlignJob job{.moving = new_id(), .fixed = new_id()};
  FakeAlignments jobs;
  std::string root;
  std::vector<AlignInput> inputs;
  bool continued = false;
};

TEST_F(AlignWorkerTest, StoresTheResultOfBothScans) {
  work(done());
  EXPECT_EQ(jobs.ready, std::vector<double>{0.75});
  ASSERT_EQ(inputs.size(), 1u);
  EXPECT_EQ(inputs[0].fixed.size[2], 9u);
  EXPECT_EQ(inputs[0].moving.size[2], 8u);
  EXPECT_EQ(inputs[0].moving_directory, root + "/" + job.moving);
  EXPECT_TRUE(continued);
}

TEST_F(AlignWorkerTest, GivesTheReasonOfARefusal) {
  Build build;
  build.verdict = refused("not_converged", "The scans could not be aligned.");
  work(build);
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"not_converged"});
  EXPECT_TRUE(jobs.ready.empty());
}

TEST_F(AlignWorkerTest, FailsIfTheChildGivesNoSoundResult) {
  Build build = done();
  build.aligned.reset();
  work(build);
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"internal"});
}

TEST_F(AlignWorkerTest, WaitsForTemporaryConditions) {
  work(fail(ErrorCode::kTooLarge, "the disk is full"));
  Build killed;
  killed.killed = true;
  work(killed);
  using namespace std::chrono_literals;
  EXPECT_EQ(jobs.put_backs,
            (std::vector<FakeAlignments::PutBack>{{1000ms, true, false}, {4000ms, false, true}}));
  EXPECT_TRUE(jobs.failures.empty());
}

TEST_F(AlignWorkerTest, LeavesAnAlignmentThatWentToAnother) {
  jobs.held = false;
  work(done());
  EXPECT_FALSE(continued);
  EXPECT_TRUE(jobs.ready.empty() && jobs.failures.empty() && jobs.put_backs.empty());
}

TEST_F(AlignWorkerTest, GivesUpAfterSeveralAttempts) {
  job.attempts = 3;
  work(done());
  EXPECT_TRUE(inputs.empty());
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"no_memory"});
}

TEST_F(AlignWorkerTest, FailsIfAScanIsMissing) {
  fs::remove_all(root + "/" + job.fixed);
  work(done());
  EXPECT_EQ(jobs.failures, std::vector<std::string>{"internal"});
}

TEST(AlignChild, TheParentAcceptsSoundNumbersOnly) {
  RigidAlignment found;
  found.to_fixed[3] = 12.5;
  found.residual_mm = 0.25;
  found.overlap = 0.5;
  const auto again = alignment_of(to_text(found));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->to_fixed, found.to_fixed);
  EXPECT_EQ(again->residual_mm, 0.25);
  found.to_fixed[0] = 2;
  EXPECT_FALSE(alignment_of(to_text(found))) << "scales";
  found.to_fixed[0] = 1;
  found.overlap = 1.5;
  EXPECT_FALSE(alignment_of(to_text(found)));
  found.overlap = 1;
  found.residual_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(alignment_of(to_text(found)));
  for (const char* text : {"", "[]", "{}", R"({"matrix":[]})", R"({"matrix":"x"})"}) {
    EXPECT_FALSE(alignment_of(text)) << text;
  }
  EXPECT_FALSE(alignment_of(std::string(kLongestAlignment + 1, ' ')));
}

}  // namespace
}  // namespace diaphane::ingest
