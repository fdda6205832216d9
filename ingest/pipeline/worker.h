#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/job_store.h"

namespace diaphane::ingest {

/// Events that a worker reports, called from its thread.
struct WorkerEvents {
  std::function<void(const std::string& code)> done = [](const std::string&) {};
  std::function<void(double seconds, std::uint64_t peak_bytes)> built = [](double, std::uint64_t) {
  };
  std::function<void(const QueueState&)> queue = [](const QueueState&) {};
  std::function<void(WaitReason)> waits = [](WaitReason) {};
  std::function<void(bool)> postgres = [](bool) {};
};

/// Processes one job after another: builds a volume, places labels or cuts a volume, stores the
/// result or the reason for a refusal, and then removes the upload. A temporary condition (a full
/// disk, too little memory, an unavailable service) ends no job. The upload stays, and the job
/// waits, longer each time, and is tried again without counting an attempt. Only conditions that
/// the upload itself may cause are limited: attempts for which memory or CPU time was short, and
/// waits for a missing file. While Postgres is unavailable, the worker keeps the result until it
/// can report it.
class Worker {
 public:
  struct Options {
    std::string upload_dir;
    std::string volume_dir;
    /// How often to look for jobs that became due without a notification.
    std::chrono::milliseconds poll{1000};
    std::chrono::milliseconds renew{1500};
    /// How long a build may continue after a stop was requested.
    std::chrono::milliseconds drain{1500};
    int most_attempts = 12;  ///< attempts for which memory or CPU time was short
    int most_waits_for_file = 12;
    std::chrono::milliseconds first_pause{1000};  ///< pause of a waiting job; doubled each time
    std::chrono::milliseconds longest_pause{60000};
    std::chrono::milliseconds longest_pause_for_memory{600000};
  };

  Worker(Options options, JobStore& jobs, Builder& builder, WorkerEvents events)
      : options_(std::move(options)), jobs_(jobs), builder_(builder), events_(std::move(events)) {}

  /// Runs until stop(). A build then has `drain` to end before its job is requeued.
  void run();
  /// Makes run() call `other` after each job, or when there is none. `other` returns whether it
  /// found work, and ends early once is_stopping() returns true.
  void alternate_with(std::function<bool()> other) { other_work_ = std::move(other); }
  bool is_stopping() const { return stopping_; }
  /// Processes one job if there is one, and returns whether there was. For tests.
  bool work_once();
  void stop() { stopping_ = true; }
  /// Returns the pause of a job after this number of consecutive waits.
  static std::chrono::milliseconds pause_after(int waits, const Options& options);
  /// Returns the pause of a job after this number of attempts for which memory or CPU time was
  /// short.
  static std::chrono::milliseconds pause_for_memory(int attempts, const Options& options);

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;

  void work(const Job& job);
  void work_upload(const Job& job);
  void finish(const Job& job, Build& build);
  void work_labels(const Job& job);
  void store_labels(const Job& job, const Build& build);
  void refuse_labels(const Job& job, const std::string& code, const std::string& text);
  void work_cut(const Job& job);
  void finish_cut(const Job& job, const volume::Volume& volume);
  void refuse_cut(const Job& job, const std::string& text);
  /// Returns a callback that renews the job's lease periodically and returns whether work on it
  /// should continue.
  Builder::ShouldContinue keep_going(const Job& job, Hold& hold);
  Result<void> store(const Job& job, volume::Volume& volume);
  void give_back(const Job& job);
  void wait(const Job& job, const Error& why);
  void wait(const Job& job, WaitReason reason, const std::string& why, bool count_attempt);
  void retry(const Job& job, const Build& build);
  void wait_for_file(const Job& job);
  void remove_original(const Job& job);
  void discard_volume(const Job& job);
  void note_postgres(bool available);
  void wait_for_work();
  bool stop_is_due();
  /// Retries `ask` until Postgres answers, or until the grace period after a stop request is over.
  template <typename Ask>
  auto insist(Ask ask) -> decltype(ask());
  std::string upload_path(const Job& job) const;
  std::string volume_path(const Job& job) const;

  Options options_;
  JobStore& jobs_;
  Builder& builder_;
  WorkerEvents events_;
  std::function<bool()> other_work_;
  std::atomic<bool> stopping_{false};
  SteadyTime stop_requested_{};
  bool postgres_available_ = true;
};

template <typename Ask>
auto Worker::insist(Ask ask) -> decltype(ask()) {
  for (;;) {
    auto answer = ask();
    const bool away = !answer && answer.error().code == ErrorCode::kUnavailable;
    note_postgres(!away);
    if (!away || stop_is_due()) return answer;
    std::this_thread::sleep_for(std::min(options_.poll, std::chrono::milliseconds(200)));
  }
}

}  // namespace diaphane::ingest
