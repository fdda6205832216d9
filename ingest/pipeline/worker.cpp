#include "ingest/pipeline/worker.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <thread>

#include "common/fault_point.h"
#include "common/ids.h"
#include "common/log.h"
#include "ingest/head/find_head.h"
#include "ingest/pipeline/doubled_pause.h"
#include "ingest/pipeline/lease.h"
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
  return doubled_pause(options.first_pause, waits, options.longest_pause);
}

std::chrono::milliseconds Worker::pause_for_memory(int attempts, const Options& options) {
  // The job may be the cause, so the next attempt is late enough for another cause to pass.
  return doubled_pause(4 * options.first_pause, attempts, options.longest_pause_for_memory);
}

std::string Worker::upload_path(const Job& job) const {
  return options_.upload_dir + "/" + job.upload_id + ".tar";
}

std::string Worker::volume_path(const Job& job) const {
  return options_.volume_dir + "/" + job.data_set_id;
}

void Worker::note_postgres(bool available) {
  events_.postgres(available);
  if (available == postgres_available_) return;
  postgres_available_ = available;
  if (available) {
    log::info("postgres_available");
  } else {
    log::warning("postgres_unavailable",
                 {{"effect", "jobs wait until Postgres is available; nothing is lost"}});
  }
}

void Worker::wait_for_work() {
  constexpr std::chrono::milliseconds kStep{50};
  for (const auto until = Clock::now() + options_.poll; !stopping_ && Clock::now() < until;) {
    if (jobs_.wait_for_work(std::min(options_.poll, kStep))) return;
  }
}

/// Returns whether a stop was requested and the grace period of the current build is over.
bool Worker::stop_is_due() {
  if (!stopping_) return false;
  if (stop_requested_ == SteadyTime{}) stop_requested_ = Clock::now();
  return Clock::now() - stop_requested_ > options_.drain;
}

void Worker::run() {
  auto next_count = Clock::now();
  while (!stopping_) {
    if (Clock::now() >= next_count) {
      if (auto queue = jobs_.queue()) events_.queue(*queue);
      next_count = Clock::now() + std::chrono::seconds(2);
    }
    const bool worked = work_once();
    const bool worked_elsewhere = !stopping_ && other_work_ && other_work_();
    if (!worked && !worked_elsewhere) wait_for_work();
  }
}

bool Worker::work_once() {
  auto claimed = jobs_.claim();
  note_postgres(claimed || claimed.error().code != ErrorCode::kUnavailable);
  if (!claimed || !*claimed) return false;
  work(**claimed);
  return true;
}

Builder::ShouldContinue Worker::keep_going(const Job& job, Hold& hold) {
  return renewing([this] { return stop_is_due(); }, options_.renew,
                  [this, &job, &hold] {
                    const auto renewed = jobs_.renew(job);
                    note_postgres(renewed || renewed.error().code != ErrorCode::kUnavailable);
                    if (renewed) hold = *renewed;
                    return hold == Hold::kOurs;
                  });
}

void Worker::work(const Job& job) {
  // Malformed IDs should never occur, but they would become part of file paths.
  if (!is_id(job.data_set_id) || (!job.cut && !is_id(job.upload_id))) return;
  try {
    if (job.cut) return work_cut(job);
    job.labels ? work_labels(job) : work_upload(job);
  } catch (const std::bad_alloc&) {
    wait(job, WaitReason::kMemory, "ingestd is short of memory", false);
  }
}

void Worker::work_upload(const Job& job) {
  log::info("ingest_started", {{"data_set", job.data_set_id},
                               {"killed", job.attempts},
                               {"interrupted", job.interruptions}});
  if (job.attempts >= options_.most_attempts) {
    Build given_up;
    given_up.verdict =
        refused("no_memory",
                "The server ran out of memory or time each time it read this upload, which is "
                "within the limits. "
                "Upload the scan again later, or contact the administrator of this server.");
    return finish(job, given_up);
  }
  fault_point("claimed");
  Hold hold = Hold::kOurs;
  const auto should_continue = keep_going(job, hold);
  auto build = builder_.build({upload_path(job), job.quota_left}, should_continue);
  fault_point("built");
  if (!build) return wait(job, build.error());
  if (hold != Hold::kOurs) {
    log::info("ingest_dropped",
              {{"data_set", job.data_set_id}, {"deleted", hold == Hold::kDeleted}});
    if (hold == Hold::kDeleted) remove_original(job);
    return;
  }
  if (build->stopped) return give_back(job);
  if (build->killed || build->no_memory || build->delayed) return retry(job, *build);
  if (build->file_missing) return wait_for_file(job);
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
  const auto pause =
      count_attempt ? pause_for_memory(job.attempts, options_) : pause_after(job.waits, options_);
  log::warning("job_waits", {{"data_set", job.data_set_id},
                             {"for", to_string(reason)},
                             {"reason", why},
                             {"waits", job.waits + 1},
                             {"pause_ms", pause.count()}});
  events_.waits(reason);
  (void)insist([&] { return jobs_.wait(job, reason, pause, count_attempt); });
}

/// Waits after memory or CPU time was short or the child was killed. The upload may be the cause,
/// so the attempt counts towards a limit.
void Worker::retry(const Job& job, const Build& build) {
  if (build.delayed) {
    return wait(job, WaitReason::kService, "the machine was too busy to finish in time", true);
  }
  wait(job, WaitReason::kMemory,
       build.killed ? "the child process was killed"
                    : "the machine ran out of memory before the child process reached its limit",
       true);
}

/// Waits for a missing file, which a replaced or restored disk may bring back, up to a limit.
void Worker::wait_for_file(const Job& job) {
  if (job.waits < options_.most_waits_for_file) {
    return wait(job, WaitReason::kService, "the upload's file is missing", false);
  }
  Build gone;
  gone.verdict =
      refused("upload_gone", "The upload is no longer available. Please upload the scan again.");
  finish(job, gone);
}

void Worker::finish(const Job& job, Build& build) {
  Verdict& verdict = build.verdict;
  const std::uint64_t bytes = build.volume.voxels.size() * sizeof(std::int16_t);
  if (verdict.ready) {
    // Only a fresh lease permits writing to the volume's directory.
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
    return verdict.ready ? jobs_.finish_ready(job, build.volume.header, bytes, head, build.frame)
                         : jobs_.finish_refused(job, verdict.code, verdict.text);
  });
  fault_point("said");
  if (!hold) return;  // stopping while Postgres is unavailable; the job is resumed later
  if (*hold == Hold::kDeleted) {
    if (verdict.ready) discard_volume(job);
    return remove_original(job);
  }
  if (*hold == Hold::kLost)
    return;  // another worker has the job, or a lost answer already finished it
  if (*hold == Hold::kOverQuota) {
    discard_volume(job);
    verdict = refused("over_quota", {});
  }
  log::info("ingest_done", {{"data_set", job.data_set_id},
                            {"result", verdict.ready ? "ready" : verdict.code},
                            {"voxels", build.volume.header.total_voxel_count()},
                            {"seconds", build.seconds},
                            {"peak_mb", static_cast<double>(build.peak_bytes) / (1 << 20)}});
  events_.done(verdict.ready ? "ready" : verdict.code);
  remove_original(job);
}

Result<void> Worker::store(const Job& job, volume::Volume& volume) {
  auto written = volume::write(volume, volume_path(job));
  if (written || written.error().code != ErrorCode::kConflict) return written;
  // A claimer that was killed between storing and reporting left this volume. It is not ready, so
  // nothing reads it.
  std::error_code error;
  fs::remove_all(volume_path(job), error);
  return volume::write(volume, volume_path(job));
}

void Worker::give_back(const Job& job) {
  const auto released = jobs_.release(job);
  log::info("ingest_returned", {{"data_set", job.data_set_id}, {"recorded", released.has_value()}});
}

void Worker::remove_original(const Job& job) {
  const auto kept = jobs_.files_are_kept();
  if (!kept || *kept) return;  // its row in `disposals` stays, and api deletes it later
  std::error_code error;
  fs::remove(upload_path(job), error);
  if (error) {
    log::error("original_not_removed", {{"upload", job.upload_id}});
    return;
  }
  fault_point("removed");
  (void)jobs_.upload_removed(job.upload_id);
}

void Worker::discard_volume(const Job& job) { volume::erase(volume_path(job)); }

}  // namespace diaphane::ingest
