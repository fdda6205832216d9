#include "ingest/pipeline/worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <thread>

#include "common/ids.h"
#include "volume/volume.h"

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;

/// A queue in memory that can be unavailable and that records its calls.
class FakeJobs final : public JobStore {
 public:
  Result<std::optional<Job>> claim() override {
    if (away > 0) return gone<std::optional<Job>>();
    if (waiting.empty()) return std::optional<Job>();
    const Job job = waiting.front();
    waiting.pop_front();
    return std::optional<Job>(job);
  }
  bool wait_for_work(std::chrono::milliseconds longest) override {
    std::this_thread::sleep_for(longest);
    return false;
  }
  Result<Hold> renew(const Job&) override {
    if (away > 0) return gone<Hold>();
    ++renewals;
    return hold;
  }
  Result<Hold> finish_ready(const Job& job, const volume::Header& header, std::uint64_t,
                            const std::string&, const std::string& frame) override {
    if (away > 0) return gone<Hold>();
    if (hold_at_finish != Hold::kOurs) return hold_at_finish;
    ready.push_back(job.data_set_id);
    last_header = header;
    last_frame = frame;
    return Hold::kOurs;
  }
  Result<Hold> finish_refused(const Job& job, const std::string& code,
                              const std::string&) override {
    if (away > 0) return gone<Hold>();
    refusals.emplace_back(job.data_set_id, code);
    return Hold::kOurs;
  }
  Result<Hold> note_cut(const Job&, const std::string& hash, const volume::Vector&) override {
    if (away > 0) return gone<Hold>();
    if (hold_at_note != Hold::kOurs) return hold_at_note;
    noted.push_back(hash);
    return Hold::kOurs;
  }
  Result<Hold> finish_cut(const Job& job, const volume::Header& header, std::uint64_t,
                          const std::string&) override {
    if (away > 0) return gone<Hold>();
    if (hold_at_finish != Hold::kOurs) return hold_at_finish;
    ready.push_back(job.data_set_id);
    last_header = header;
    return Hold::kOurs;
  }
  Result<Hold> finish_cut_refused(const Job& job, const std::string& text) override {
    refusals.emplace_back(job.data_set_id, text);
    return Hold::kOurs;
  }
  Result<Hold> finish_labels(const Job& job, const volume::LabelSet& labels,
                             std::uint64_t) override {
    if (away > 0) return gone<Hold>();
    if (hold_at_finish != Hold::kOurs) return hold_at_finish;
    labelled.emplace_back(job.data_set_id, labels.table.size());
    return Hold::kOurs;
  }
  Result<Hold> finish_labels_refused(const Job& job, const std::string& code,
                                     const std::string&) override {
    refusals.emplace_back(job.data_set_id, code);
    return Hold::kOurs;
  }
  Result<void> release(const Job& job) override {
    released.push_back(job.data_set_id);
    return {};
  }
  Result<bool> files_are_kept() override {
    if (away > 0) return gone<bool>();
    return backup_runs;
  }
  Result<void> upload_removed(const std::string& id) override {
    removed.push_back(id);
    return {};
  }
  Result<void> wait(const Job& job, WaitReason reason, std::chrono::milliseconds pause,
                    bool count_attempt) override {
    if (away > 0) return gone<void>();
    waits.push_back({job.data_set_id, reason, pause, count_attempt});
    Job again = job;
    ++again.waits;
    again.attempts += count_attempt ? 1 : 0;
    waiting.push_back(again);
    return {};
  }
  Result<void> leave_to_large(const Job& job) override {
    left_to_large.push_back(job.data_set_id);
    return {};
  }
  Result<QueueState> queue() override {
    return QueueState{static_cast<std::int64_t>(waiting.size()), 0};
  }

  template <typename T>
  Result<T> gone() {
    --away;
    return fail(ErrorCode::kUnavailable, "away");
  }

  std::deque<Job> waiting;
  int away = 0;  ///< number of calls that get no answer
  bool backup_runs = false;
  std::atomic<int> renewals{0};
  Hold hold = Hold::kOurs, hold_at_finish = Hold::kOurs, hold_at_note = Hold::kOurs;
  struct Wait {
    std::string data_set_id;
    WaitReason reason;
    std::chrono::milliseconds pause;
    bool counted;
  };
  std::vector<Wait> waits;
  std::vector<std::string> ready, released, removed, noted, left_to_large;
  std::vector<std::pair<std::string, std::string>> refusals;
  std::vector<std::pair<std::string, std::size_t>> labelled;
  volume::Header last_header;
  std::string last_frame;
};

class FakeBuilder final : public Builder {
 public:
  Result<Build> build(const UploadInput&, const ShouldContinue& should_continue) override {
    ++builds;
    if (no_memory) throw std::bad_alloc();
    if (failure) return tl::unexpected(*failure);
    Build result;
    result.killed = killed;
    result.no_memory = machine_short;
    result.delayed = delayed;
    result.file_missing = file_missing;
    result.too_large = too_large;
    const auto until = std::chrono::steady_clock::now() + takes;
    while (std::chrono::steady_clock::now() < until && !(ends_early && ends_early())) {
      if (!should_continue()) {
        result.stopped = true;
        return result;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    result.verdict = verdict;
    if (verdict.ready) {
      result.volume.header.size = {4, 3, 2};
      result.volume.voxels.assign(24, 7);
      volume::measure(result.volume);
    }
    return result;
  }
  Result<Build> cut(const CutInput& input, const ShouldContinue&) override {
    ++builds;
    if (failure) return tl::unexpected(*failure);
    Build result;
    result.verdict = verdict;
    if (!verdict.ready) return result;
    auto left = volume::cut_volume(*volume::read(input.volume_directory, true), input.region);
    result.volume = std::move(*left);
    return result;
  }
  Result<Build> place_labels(const LabelInput& input, const ShouldContinue&) override {
    ++builds;
    if (failure) return tl::unexpected(*failure);
    Build result;
    result.killed = killed;
    result.file_missing = file_missing;
    result.verdict = verdict;
    if (!verdict.ready) return result;
    volume::LabelSet& set = result.volume.label_set;
    set.table = {{.number = 3, .name = "Liver", .colour = {200, 40, 30}}};
    set.labels.size = input.scan.size;
    set.labels.voxels.assign(input.scan.voxel_count(), 1);
    result.labels = volume::encode(set);
    return result;
  }
  Verdict verdict;
  std::optional<Error> failure;
  bool killed = false, delayed = false, too_large = false, no_memory = false, machine_short = false,
       file_missing = false;
  std::chrono::milliseconds takes{0};
  std::function<bool()> ends_early;
  int builds = 0;
};

class WorkerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "diaphane-worker-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    fs::create_directories(root_ / "uploads");
    fs::create_directories(root_ / "volumes");
    options_.upload_dir = (root_ / "uploads").string();
    options_.volume_dir = (root_ / "volumes").string();
    options_.poll = std::chrono::milliseconds(5);
    options_.renew = std::chrono::milliseconds(10);
    options_.drain = std::chrono::milliseconds(50);
    builder_.verdict.ready = true;
  }
  void TearDown() override { fs::remove_all(root_); }

  Job put(int attempts = 0) {
    const std::string id = new_id();
    std::ofstream(root_ / "uploads" / (id + ".tar")) << "original";
    Job job;
    job.data_set_id = job.upload_id = id;
    job.attempts = attempts;
    jobs_.waiting.push_back(job);
    return job;
  }
  /// Queues labels for a stored scan, which is made if `scan` names none.
  Job put_labels(std::string scan = {}) {
    Job job = put();
    jobs_.waiting.back().labels = job.labels = true;
    if (scan.empty()) {
      scan = new_id();
      volume::Volume volume;
      volume.header.size = {4, 3, 2};
      volume.voxels.assign(24, 7);
      volume::measure(volume);
      EXPECT_TRUE(volume::write(volume, (root_ / "volumes" / scan).string()).has_value());
    }
    jobs_.waiting.back().data_set_id = job.data_set_id = scan;
    return job;
  }
  bool original_there(const Job& job) const {
    return fs::exists(root_ / "uploads" / (job.upload_id + ".tar"));
  }
  fs::path volume_of(const Job& job) const { return root_ / "volumes" / job.data_set_id; }
  Worker worker() { return Worker(options_, jobs_, builder_, {}); }

  fs::path root_;
  Worker::Options options_;
  FakeJobs jobs_;
  FakeBuilder builder_;
};

TEST_F(WorkerTest, SuccessStoresVolumeAndRemovesUpload) {
  const Job job = put();
  auto w = worker();
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_TRUE(volume::read(volume_of(job).string(), true).has_value());
  EXPECT_FALSE(original_there(job));
  EXPECT_EQ(jobs_.removed, std::vector{job.upload_id});
  EXPECT_FALSE(w.work_once()) << "nothing waits";
}

TEST_F(WorkerTest, LeavesTheUploadWhileABackupMayNeedIt) {
  jobs_.backup_runs = true;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_TRUE(original_there(job));
  EXPECT_TRUE(jobs_.removed.empty()) << "its row lets api delete it later";
}

TEST_F(WorkerTest, RefusalRemovesUpload) {
  builder_.verdict = refused("scout", "This is a scout.");
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.refusals, (std::vector{std::pair(job.data_set_id, std::string("scout"))}));
  EXPECT_FALSE(original_there(job));
  EXPECT_FALSE(fs::exists(volume_of(job)));
}

TEST_F(WorkerTest, LabelsAreAddedToTheStoredScan) {
  const Job job = put_labels();
  auto w = worker();
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.labelled, (std::vector{std::pair(job.data_set_id, std::size_t{1})}));
  EXPECT_EQ(volume::read(volume_of(job).string(), false)->label_set.table.front().name, "Liver");
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, RefusedLabelsLeaveTheScanAndItsEarlierLabels) {
  put_labels();
  EXPECT_TRUE(worker().work_once());
  const std::string id = jobs_.labelled.front().first;
  builder_.verdict = refused("labels_other_scan", "They belong to another scan.");
  const Job again = put_labels(id);
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.refusals, (std::vector{std::pair(id, std::string("labels_other_scan"))}));
  EXPECT_FALSE(original_there(again));
  EXPECT_EQ(volume::read(volume_of(again).string(), false)->label_set.table.size(), 1U);
}

TEST_F(WorkerTest, LabelsBeyondTheQuotaAreRefused) {
  put_labels();
  jobs_.waiting.front().quota_left = 24 * sizeof(std::int16_t);
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.refusals.front().second, "over_quota");
  EXPECT_TRUE(jobs_.labelled.empty());
}

TEST_F(WorkerTest, LabelsWaitWhileTheDiskIsUnavailable) {
  const Job job = put_labels();
  builder_.failure = Error{ErrorCode::kUnavailable, "the disk is unavailable", {}};
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.waits.size(), 1U);
  EXPECT_TRUE(original_there(job));
}

TEST_F(WorkerTest, KeepsResultUntilPostgresIsAvailable) {
  const Job job = put();
  auto w = worker();
  builder_.takes = std::chrono::milliseconds(30);
  std::thread thread([&] { w.work_once(); });
  while (builder_.builds == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  jobs_.away = 4;
  thread.join();
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, GivesUpJobThatNeverGetsMemoryWithoutReadingIt) {
  const Job job = put(options_.most_attempts);
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(builder_.builds, 0);
  ASSERT_EQ(jobs_.refusals.size(), 1u);
  EXPECT_EQ(jobs_.refusals[0].second, "no_memory");
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, InterruptionsDoNotCountAsAttempts) {
  const Job job = put();
  jobs_.waiting.front().interruptions = 1000;
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
}

TEST_F(WorkerTest, RetriesMissingFileAndThenGivesUp) {
  builder_.file_missing = true;
  const Job job = put();
  auto w = worker();
  for (int i = 0; i < options_.most_waits_for_file; ++i) {
    EXPECT_TRUE(w.work_once());
    EXPECT_EQ(jobs_.waits.back().reason, WaitReason::kService);
    EXPECT_TRUE(jobs_.refusals.empty());
  }
  EXPECT_TRUE(w.work_once());
  ASSERT_EQ(jobs_.refusals.size(), 1u);
  EXPECT_EQ(jobs_.refusals[0].second, "upload_gone");
}

TEST_F(WorkerTest, TransientFailureKeepsUploadAndCountsNoAttempt) {
  const std::pair<ErrorCode, WaitReason> cases[] = {{ErrorCode::kTooLarge, WaitReason::kRoom},
                                                    {ErrorCode::kOutOfMemory, WaitReason::kMemory},
                                                    {ErrorCode::kUnavailable, WaitReason::kService},
                                                    {ErrorCode::kInternal, WaitReason::kService}};
  const Job job = put();
  auto w = worker();
  for (const auto& [code, reason] : cases) {
    builder_.failure = Error{code, "not now", {}};
    EXPECT_TRUE(w.work_once());
    ASSERT_FALSE(jobs_.waits.empty());
    EXPECT_EQ(jobs_.waits.back().reason, reason);
    EXPECT_FALSE(jobs_.waits.back().counted);
    EXPECT_TRUE(jobs_.refusals.empty());
    EXPECT_TRUE(original_there(job));
  }
  builder_.failure.reset();
  builder_.no_memory = true;
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.waits.back().reason, WaitReason::kMemory);
  builder_.no_memory = false;
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, StoreFailureKeepsUploadUntilItRecovers) {
  const Job job = put();
  fs::remove(root_ / "volumes");
  auto w = worker();
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.waits.size(), 5u);
  EXPECT_TRUE(jobs_.refusals.empty());
  EXPECT_TRUE(original_there(job));
  fs::create_directories(root_ / "volumes");
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
}

TEST_F(WorkerTest, BackoffDoublesUpToALimit) {
  Worker::Options options;
  EXPECT_EQ(Worker::pause_after(0, options), options.first_pause);
  EXPECT_EQ(Worker::pause_after(3, options), 8 * options.first_pause);
  EXPECT_EQ(Worker::pause_after(6, options), options.longest_pause);
  EXPECT_EQ(Worker::pause_after(1'000'000, options), options.longest_pause);
  EXPECT_EQ(Worker::pause_for_memory(2, options), 16 * options.first_pause);
  EXPECT_EQ(Worker::pause_for_memory(11, options), options.longest_pause_for_memory);
}

TEST_F(WorkerTest, RetriesKilledChildAndGivesUpAfterTheLastAttempt) {
  const Job job = put();
  auto w = worker();
  for (int i = 0; i < options_.most_attempts; ++i) {
    builder_.killed = i % 2 == 0;
    builder_.machine_short = i % 2 != 0;
    EXPECT_TRUE(original_there(job));
    EXPECT_TRUE(w.work_once());
    EXPECT_TRUE(jobs_.waits.back().counted);
    EXPECT_EQ(jobs_.waits.back().reason, WaitReason::kMemory);
    EXPECT_EQ(jobs_.waits.back().pause, Worker::pause_for_memory(i, options_));
  }
  EXPECT_TRUE(w.work_once());
  ASSERT_EQ(jobs_.refusals.size(), 1u);
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, RetriesBuildsThatABusyMachineTimedOut) {
  builder_.delayed = true;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_TRUE(jobs_.refusals.empty());
  EXPECT_TRUE(original_there(job));
  EXPECT_EQ(jobs_.waits.back().reason, WaitReason::kService);
  EXPECT_TRUE(jobs_.waits.back().counted);
}

TEST_F(WorkerTest, LightWorkerLeavesLargeVolumeToTheOther) {
  builder_.too_large = true;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.left_to_large, std::vector{job.data_set_id});
  EXPECT_TRUE(original_there(job));
}

TEST_F(WorkerTest, VolumeOverQuotaLeavesNoFiles) {
  jobs_.hold_at_finish = Hold::kOverQuota;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_FALSE(fs::exists(volume_of(job)));
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, DataSetDeletedDuringBuildLeavesNoFiles) {
  jobs_.hold_at_finish = Hold::kDeleted;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_FALSE(fs::exists(volume_of(job)));
  EXPECT_FALSE(original_there(job));
}

TEST_F(WorkerTest, LostLeaseStopsBuildAndKeepsUpload) {
  builder_.takes = std::chrono::seconds(20);
  jobs_.hold = Hold::kLost;
  const Job job = put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_TRUE(original_there(job)) << "somebody else needs it";
  EXPECT_FALSE(fs::exists(volume_of(job)));
  EXPECT_TRUE(jobs_.released.empty());
}

TEST_F(WorkerTest, RenewsLeaseDuringBuild) {
  builder_.takes = std::chrono::seconds(60);
  builder_.ends_early = [this] { return jobs_.renewals >= 3; };
  put();
  EXPECT_TRUE(worker().work_once());
  EXPECT_GE(jobs_.renewals, 3);
  EXPECT_EQ(jobs_.ready.size(), 1u);
}

TEST_F(WorkerTest, StoppingReleasesTheJobAfterTheGracePeriod) {
  builder_.takes = std::chrono::seconds(20);
  const Job job = put();
  auto w = worker();
  std::thread thread([&] { w.run(); });
  while (builder_.builds == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const auto before = std::chrono::steady_clock::now();
  w.stop();
  thread.join();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(15));
  EXPECT_EQ(jobs_.released, std::vector{job.data_set_id});
  EXPECT_TRUE(original_there(job));
}

TEST_F(WorkerTest, ReplacesIncompleteVolumeOfKilledWorker) {
  const Job job = put();
  fs::create_directories(volume_of(job));
  std::ofstream(volume_of(job) / "voxels.i16") << "old";
  EXPECT_TRUE(worker().work_once());
  EXPECT_TRUE(volume::read(volume_of(job).string(), true).has_value());
  EXPECT_EQ(jobs_.ready.size(), 1u);
}

/// A stored volume of ones with a row of markers, and an order to keep its lower half.
class CutTest : public WorkerTest {
 protected:
  Job order(int attempts = 0) {
    volume::Volume stored;
    stored.header.size = {16, 16, 16};
    stored.voxels.assign(16 * 16 * 16, 1);
    std::fill(stored.voxels.end() - 16, stored.voxels.end(), std::int16_t{12345});
    volume::measure(stored);
    Job job;
    job.data_set_id = new_id();
    job.attempts = attempts;
    EXPECT_TRUE(volume::write(stored, volume_of(job).string()).has_value());
    job.cut = CutOrder{{{-8, -8, -8}, {8, 8, 0}, {}}, stored.header.content_hash, {}};
    jobs_.waiting.push_back(job);
    return job;
  }
  volume::Volume stored(const Job& job) const {
    return *volume::read(volume_of(job).string(), true);
  }
  std::size_t in_store() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(root_ / "volumes"), fs::directory_iterator()));
  }
  void expect_old(const Job& job) const {
    EXPECT_EQ(stored(job).header.content_hash, job.cut->of);
    EXPECT_EQ(in_store(), 1U);
  }
};

TEST_F(CutTest, CutVolumeReplacesTheOriginal) {
  const Job job = order();
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_EQ(stored(job).header.size, (std::array<std::uint32_t, 3>{16, 16, 8}));
  EXPECT_EQ(stored(job).header.maximum, 1);
  EXPECT_EQ(jobs_.noted, std::vector{stored(job).header.content_hash});
  EXPECT_EQ(jobs_.last_header.content_hash, jobs_.noted[0]);
  EXPECT_EQ(in_store(), 1U);
}

TEST_F(CutTest, OrderForAnotherVolumeChangesNothing) {
  Job job = order();
  jobs_.waiting.front().cut->of = "blake2b:another";
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(builder_.builds, 0);
  ASSERT_EQ(jobs_.refusals.size(), 1U);
  expect_old(job);
}

TEST_F(CutTest, RegionThatKeepsTooLittleChangesNothing) {
  Job job = order();
  jobs_.waiting.front().cut->region = {};
  EXPECT_TRUE(worker().work_once());
  ASSERT_EQ(jobs_.refusals.size(), 1U);
  expect_old(job);
}

TEST_F(CutTest, FailedChildChangesNothing) {
  const Job job = order();
  builder_.verdict = refused("too_large", "It needs too much.");
  EXPECT_TRUE(worker().work_once());
  ASSERT_EQ(jobs_.refusals.size(), 1U);
  EXPECT_EQ(jobs_.refusals[0].second, "It needs too much. Nothing was removed.");
  expect_old(job);
}

TEST_F(CutTest, FullDiskKeepsTheOldVolumeAndTheOrder) {
  const Job job = order();
  builder_.failure = Error{ErrorCode::kTooLarge, "the disk is full", {}};
  auto w = worker();
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(w.work_once());
  EXPECT_TRUE(jobs_.refusals.empty());
  EXPECT_EQ(jobs_.waits.size(), 5U);
  EXPECT_EQ(jobs_.waits.back().reason, WaitReason::kRoom);
  expect_old(job);
  builder_.failure.reset();
  EXPECT_TRUE(w.work_once());
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
}

TEST_F(CutTest, LostLeaseChangesNothing) {
  const Job job = order();
  jobs_.hold_at_note = Hold::kLost;
  EXPECT_TRUE(worker().work_once());
  EXPECT_TRUE(jobs_.ready.empty());
  expect_old(job);
}

TEST_F(CutTest, ResumesAttemptThatWasKilledAfterTheExchange) {
  Job job = order();
  volume::Volume left = *volume::cut_volume(stored(job), job.cut->region);
  ASSERT_TRUE(volume::replace(left, volume_of(job).string(), []() -> Result<void> { return {}; }));
  fs::create_directory(root_ / "volumes" /
                       ".tmp-old");  // what the killed worker had no time to remove
  jobs_.waiting.front().cut->result = left.header.content_hash;
  jobs_.waiting.front().attempts = 70;
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(builder_.builds, 0);
  EXPECT_EQ(jobs_.ready, std::vector{job.data_set_id});
  EXPECT_EQ(in_store(), 1U);
}

TEST_F(CutTest, DataSetDeletedDuringCutLeavesNoFiles) {
  const Job job = order();
  jobs_.hold_at_finish = Hold::kDeleted;
  EXPECT_TRUE(worker().work_once());
  EXPECT_EQ(in_store(), 0U);
}

}  // namespace
}  // namespace diaphane::ingest
