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

/// What the worker tells about itself; called from its thread.
struct WorkerEvents {
  std::function<void(const std::string& code)> done = [](const std::string&) {};
  std::function<void(double seconds, std::uint64_t peak_bytes)> built = [](double, std::uint64_t) {
  };
  std::function<void(const QueueState&)> queue = [](const QueueState&) {};
  std::function<void(WaitReason)> waits = [](WaitReason) {};
  std::function<void(bool)> postgres = [](bool) {};
};

/// Takes one job after another: builds it, keeps the volume or says why not, and removes the
/// original afterwards. A condition that passes (a full disk, too little memory, a part that is
/// away) ends no job: the original stays, the job waits, longer each time, and is tried again
/// without counting an attempt. While Postgres is away, the worker holds the result until it can
/// say so.
class Worker {
 public:
  struct Options {
    std::string upload_dir;
    std::string volume_dir;
    std::chrono::milliseconds poll{200};
    std::chrono::milliseconds renew{1500};
    std::chrono::milliseconds drain{1500};  ///< how long a build may go on once a stop is wanted
    int most_attempts = 3;
    std::chrono::milliseconds first_pause{1000};  ///< of a job that waits; doubled each time
    std::chrono::milliseconds longest_pause{60000};
  };

  Worker(Options options, JobStore& jobs, Builder& builder, WorkerEvents events)
      : options_(std::move(options)), jobs_(jobs), builder_(builder), events_(std::move(events)) {}

  /// Until stop(); then a build has `drain` to end before it is given back.
  void run();
  /// One job, if there is one: true. For tests.
  bool work_once();
  void stop() { stopping_ = true; }
  /// How long a job pauses that has waited so often in a row before.
  static std::chrono::milliseconds pause_after(int waits, const Options& options);

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;

  void work(const Job& job);
  void work_upload(const Job& job);
  void finish(const Job& job, Build& build);
  void work_cut(const Job& job);
  void finish_cut(const Job& job, const volume::Volume& volume);
  void refuse_cut(const Job& job, const std::string& text);
  /// Says whether a job that is being worked on is to go on; renews its lease now and then.
  Builder::GoOn keep_going(const Job& job, Hold& hold);
  Result<void> store(const Job& job, volume::Volume& volume);
  void give_back(const Job& job);
  void wait(const Job& job, const Error& why);
  void wait(const Job& job, WaitReason reason, const std::string& why, bool count_attempt);
  void child_was_killed(const Job& job);
  void remove_original(const Job& job);
  void discard_volume(const Job& job);
  void note_postgres(bool there);
  void pause(std::chrono::milliseconds span);
  bool stop_is_due();
  /// Asks until Postgres answers, or a stop is wanted.
  template <typename Ask>
  auto insist(Ask ask) -> decltype(ask());
  std::string upload_path(const Job& job) const;
  std::string volume_path(const Job& job) const;

  Options options_;
  JobStore& jobs_;
  Builder& builder_;
  WorkerEvents events_;
  std::atomic<bool> stopping_{false};
  SteadyTime stop_seen_{};
  bool postgres_there_ = true;
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
