#include "ingest/pipeline/align_work.h"

#include "common/ids.h"
#include "common/log.h"
#include "ingest/pipeline/doubled_pause.h"
#include "ingest/pipeline/lease.h"
#include "volume/volume.h"

namespace diaphane::ingest {

bool AlignWorker::work_once(const std::function<bool()>& is_stopping) {
  const auto claimed = jobs_.claim();
  if (!claimed || !*claimed) return false;
  work(**claimed, is_stopping);
  return true;
}

void AlignWorker::wait(const AlignJob& job, const Error& why) {
  const auto pause = doubled_pause(options_.first_pause, job.waits, options_.longest_pause);
  log::warning("alignment_waits", {{"moving", job.moving},
                                   {"fixed", job.fixed},
                                   {"reason", why.message},
                                   {"waits", job.waits + 1}});
  (void)jobs_.put_back(job, pause, true, false);
}

void AlignWorker::work(const AlignJob& job, const std::function<bool()>& is_stopping) {
  // Malformed IDs should never occur, but they would become part of file paths.
  if (!is_id(job.moving) || !is_id(job.fixed)) return;
  if (job.attempts >= options_.most_attempts) {
    (void)jobs_.fail_with(job, "no_memory");
    return;
  }
  AlignInput input;
  input.fixed_directory = options_.volume_dir + "/" + job.fixed;
  input.moving_directory = options_.volume_dir + "/" + job.moving;
  for (const auto& [directory, header] : {std::pair{&input.fixed_directory, &input.fixed},
                                          {&input.moving_directory, &input.moving}}) {
    const auto read = volume::read_header(*directory);
    if (!read && read.error().code == ErrorCode::kUnavailable) return wait(job, read.error());
    if (!read) {
      (void)jobs_.fail_with(job, "internal");
      return;
    }
    *header = *read;
  }
  bool ours = true;
  const auto should_continue = renewing(is_stopping, options_.renew, [&] {
    if (const auto renewed = jobs_.renew(job)) ours = *renewed;
    return ours;
  });
  const auto build = align_(input, should_continue);
  if (!build) return wait(job, build.error());
  if (ours) settle(job, *build);
}

void AlignWorker::settle(const AlignJob& job, const Build& build) {
  if (build.stopped) {
    (void)jobs_.put_back(job, {}, false, false);
  } else if (build.killed || build.no_memory || build.delayed) {
    log::warning("alignment_retried",
                 {{"moving", job.moving}, {"fixed", job.fixed}, {"attempts", job.attempts + 1}});
    (void)jobs_.put_back(job, options_.first_pause * 4, false, true);
  } else if (build.verdict.ready && build.aligned) {
    const auto done = jobs_.finish(job, *build.aligned);
    if (!done || !*done) return;
    log::info("alignment_done", {{"moving", job.moving},
                                 {"fixed", job.fixed},
                                 {"residual_mm", build.aligned->residual_mm},
                                 {"overlap", build.aligned->overlap},
                                 {"seconds", build.seconds},
                                 {"peak_mb", static_cast<double>(build.peak_bytes) / (1 << 20)}});
  } else {
    const std::string reason = build.verdict.ready ? "internal" : build.verdict.code;
    log::info("alignment_refused",
              {{"moving", job.moving}, {"fixed", job.fixed}, {"result", reason}});
    (void)jobs_.fail_with(job, reason);
  }
}

}  // namespace diaphane::ingest
