#include "ingest/pipeline/worker.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <thread>

#include "common/fault_point.h"
#include "common/ids.h"
#include "common/log.h"
#include "ingest/head/find_head.h"
#include "volume/store.h"

namespace diaphane::ingest {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const char* to_string(WaitReason reason) {
  switch (reason) {
    case WaitReason::kRoom:
      return "room";
    case WaitReason::kMemory:
      return "memory";
    case WaitReason::kService:
      break;
  }
  return "service";
}

namespace {

WaitReason reason_of(ErrorCode code) {
  if (code == ErrorCode::kTooLarge) return WaitReason::kRoom;
  return code == ErrorCode::kOutOfMemory ? WaitReason::kMemory : WaitReason::kService;
}

}  // namespace

std::chrono::milliseconds Worker::pause_after(int waits, const Options& options) {
  constexpr int kMostDoublings = 20;
  const auto pause = options.first_pause * (1LL << std::clamp(waits, 0, kMostDoublings));
  return std::min<std::chrono::milliseconds>(pause, options.longest_pause);
}

std::string Worker::upload_path(const Job& job) const {
  return options_.upload_dir + "/" + job.upload_id + ".tar";
}

std::string Worker::volume_path(const Job& job) const {
  return options_.volume_dir + "/" + job.data_set_id;
}

void Worker::note_postgres(bool there) {
  events_.postgres(there);
  if (there == postgres_there_) return;
  postgres_there_ = there;
  if (there) {
    log::info("postgres_back");
  } else {
    log::warning("postgres_away", {{"effect", "jobs wait; nothing is lost"}});
  }
}

void Worker::pause(std::chrono::milliseconds span) {
  constexpr std::chrono::milliseconds kStep{50};
  for (const auto until = Clock::now() + span; !stopping_ && Clock::now() < until;) {
    std::this_thread::sleep_for(std::min(span, kStep));
  }
}

/// A stop is wanted, and the time that a build may still have is over.
bool Worker::stop_is_due() {
  if (!stopping_) return false;
  if (stop_seen_ == SteadyTime{}) stop_seen_ = Clock::now();
  return Clock::now() - stop_seen_ > options_.drain;
}

void Worker::run() {
  auto next_count = Clock::now();
  while (!stopping_) {
    if (Clock::now() >= next_count) {
      if (auto queue = jobs_.queue()) events_.queue(*queue);
      next_count = Clock::now() + std::chrono::seconds(2);
    }
    if (!work_once()) pause(options_.poll);
  }
}

bool Worker::work_once() {
  auto claimed = jobs_.claim();
  note_postgres(claimed || claimed.error().code != ErrorCode::kUnavailable);
  if (!claimed || !*claimed) return false;
  work(**claimed);
  return true;
}

Builder::GoOn Worker::keep_going(const Job& job, Hold& hold) {
  return [this, &job, &hold, next_renewal = Clock::now() + options_.renew]() mutable {
    if (stop_is_due()) return false;
    if (Clock::now() < next_renewal) return true;
    next_renewal = Clock::now() + options_.renew;
    auto renewed = jobs_.renew(job);
    note_postgres(renewed || renewed.error().code != ErrorCode::kUnavailable);
    // While Postgres is away nobody else can claim it either.
    if (renewed) hold = *renewed;
    return hold == Hold::kOurs;
  };
}

void Worker::work(const Job& job) {
  // Never: a path is made of them.
  if (!is_id(job.data_set_id) || (!job.cut && !is_id(job.upload_id))) return;
  try {
    job.cut ? work_cut(job) : work_upload(job);
  } catch (const std::bad_alloc&) {
    wait(job, WaitReason::kMemory, "ingestd has too little memory", false);
  }
}

void Worker::work_upload(const Job& job) {
  log::info("ingest_begun", {{"data_set", job.data_set_id}, {"attempt", job.attempts}});
  if (job.attempts > options_.most_attempts) {
    Build given_up;
    given_up.verdict =
        refused("internal", "This upload could not be processed; please send it again.");
    return finish(job, given_up);
  }
  fault_point("claimed");
  Hold hold = Hold::kOurs;
  const auto go_on = keep_going(job, hold);
  auto build = builder_.build({upload_path(job), job.quota_left}, go_on);
  fault_point("built");
  if (!build) return wait(job, build.error());
  if (hold != Hold::kOurs) {
    log::info("ingest_dropped",
              {{"data_set", job.data_set_id}, {"deleted", hold == Hold::kDeleted}});
    if (hold == Hold::kDeleted) remove_original(job);
    return;
  }
  if (build->stopped) return give_back(job);
  if (build->killed) return child_was_killed(job);
  if (build->too_large) {
    (void)insist([&] { return jobs_.leave_to_large(job); });
    return;
  }
  events_.built(build->seconds, build->peak_bytes);
  finish(job, *build);
}

void Worker::wait(const Job& job, const Error& why) {
  wait(job, reason_of(why.code), why.message, false);
}

void Worker::wait(const Job& job, WaitReason reason, const std::string& why, bool count_attempt) {
  // Where the job may be the cause, the next attempt is far enough away for another cause to pass.
  constexpr int kLonger = 2;
  const auto pause = pause_after(job.waits + (count_attempt ? kLonger : 0), options_);
  log::warning("job_waits", {{"data_set", job.data_set_id},
                             {"for", to_string(reason)},
                             {"reason", why},
                             {"waits", job.waits + 1},
                             {"pause_ms", pause.count()}});
  events_.waits(reason);
  (void)insist([&] { return jobs_.wait(job, reason, pause, count_attempt); });
}

/// Memory was short, or somebody killed it. A job that has its child killed every time is given up
/// after the usual number of attempts.
void Worker::child_was_killed(const Job& job) {
  wait(job, WaitReason::kMemory, "the child was killed", true);
}

void Worker::finish(const Job& job, Build& build) {
  Verdict& verdict = build.verdict;
  const std::uint64_t bytes = build.volume.voxels.size() * sizeof(std::int16_t);
  if (verdict.ready) {
    // Only with a fresh lease is the volume's directory ours to write.
    const auto fresh = insist([&] { return jobs_.renew(job); });
    if (!fresh || *fresh != Hold::kOurs) {
      if (fresh && *fresh == Hold::kDeleted) remove_original(job);
      return;
    }
    if (auto stored = store(job, build.volume); !stored) return wait(job, stored.error());
    fault_point("stored");
  }
  const std::string head = verdict.ready ? to_json(find_head(build.volume)) : std::string();
  const auto hold = insist([&] {
    return verdict.ready ? jobs_.finish_ready(job, build.volume.header, bytes, head)
                         : jobs_.finish_refused(job, verdict.code, verdict.text);
  });
  fault_point("said");
  if (!hold) return;  // stopping while Postgres is away: taken up again later
  if (*hold == Hold::kDeleted) {
    if (verdict.ready) discard_volume(job);
    return remove_original(job);
  }
  if (*hold == Hold::kLost)
    return;  // somebody else's now, or said already by an answer that was lost
  if (*hold == Hold::kOverQuota) {
    discard_volume(job);
    verdict = refused("over_quota", {});
  }
  log::info("ingest_done", {{"data_set", job.data_set_id},
                            {"result", verdict.ready ? "ready" : verdict.code},
                            {"voxels", build.volume.header.voxel_count()},
                            {"seconds", build.seconds},
                            {"peak_mb", static_cast<double>(build.peak_bytes) / (1 << 20)}});
  events_.done(verdict.ready ? "ready" : verdict.code);
  remove_original(job);
}

Result<void> Worker::store(const Job& job, volume::Volume& volume) {
  auto written = volume::write(volume, volume_path(job));
  if (written || written.error().code != ErrorCode::kConflict) return written;
  // Left by a claimer that was killed between storing and saying so. Nobody reads it: it is not
  // ready.
  std::error_code error;
  fs::remove_all(volume_path(job), error);
  return volume::write(volume, volume_path(job));
}

void Worker::give_back(const Job& job) {
  const auto released = jobs_.release(job);
  log::info("ingest_given_back", {{"data_set", job.data_set_id}, {"said", released.has_value()}});
}

void Worker::remove_original(const Job& job) {
  std::error_code error;
  fs::remove(upload_path(job), error);
  if (error) {
    log::error("original_not_removed", {{"upload", job.upload_id}});
    return;  // its row in `disposals` stays, and `api` tries again
  }
  fault_point("removed");
  (void)jobs_.upload_removed(job.upload_id);
}

void Worker::discard_volume(const Job& job) { volume::erase(volume_path(job)); }

}  // namespace diaphane::ingest
