#include "ingest/pipeline/export_work.h"

#include <filesystem>

#include "common/ids.h"
#include "common/log.h"
#include "ingest/pipeline/doubled_pause.h"
#include "ingest/pipeline/lease.h"
#include "volume/volume.h"

namespace diaphane::ingest {

namespace fs = std::filesystem;

namespace {

/// Deletes what workers that were killed left of an export.
void remove_rests(const std::string& directory, const std::string& id) {
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->path().filename().string().starts_with(".tmp-" + id))
      fs::remove(entry->path(), ignored);
  }
}

/// Returns the verdict in words that suit an export instead of an upload.
Verdict of_export(const Verdict& verdict) {
  if (verdict.code == "too_slow") return refused("too_slow", "This export took too long.");
  if (verdict.code == "unreadable") return refused("internal", "The scan could not be exported.");
  return verdict;
}

}  // namespace

bool ExportWorker::work_once(const std::function<bool()>& is_stopping) {
  const auto claimed = jobs_.claim();
  if (!claimed || !*claimed) return false;
  work(**claimed, is_stopping);
  return true;
}

void ExportWorker::wait(const ExportJob& job, const Error& why) {
  const auto pause = doubled_pause(options_.first_pause, job.waits, options_.longest_pause);
  log::warning("export_waits", {{"export", job.id},
                                {"data_set", job.data_set_id},
                                {"reason", why.message},
                                {"waits", job.waits + 1}});
  (void)jobs_.put_back(job, pause, true, false);
}

void ExportWorker::work(const ExportJob& job, const std::function<bool()>& is_stopping) {
  // Malformed IDs should never occur, but they would become part of file paths.
  if (!is_id(job.id) || !is_id(job.data_set_id)) return;
  if (job.attempts > 0) remove_rests(options_.export_dir, job.id);
  if (job.attempts >= options_.most_attempts) {
    (void)jobs_.fail_with(job, "no_memory",
                          "The server ran out of memory or time each time it made this export.");
    return;
  }
  const std::string directory = options_.volume_dir + "/" + job.data_set_id;
  const auto header = volume::read_header(directory);
  if (!header && header.error().code == ErrorCode::kUnavailable) return wait(job, header.error());
  if (!header) {
    (void)jobs_.fail_with(job, "internal", "The stored scan cannot be read.");
    return;
  }
  std::error_code error;
  fs::create_directories(options_.export_dir, error);
  if (error)
    return wait(job, {ErrorCode::kUnavailable, "the export directory is not writable", {}});
  // A worker that has lost its lease without knowing must not write to the file of the next one.
  const std::string unfinished = options_.export_dir + "/.tmp-" + job.id + "-" + new_id();
  bool ours = true;
  const auto should_continue = renewing(is_stopping, options_.renew, [&] {
    if (const auto renewed = jobs_.renew(job)) ours = *renewed;
    return ours;
  });
  const auto build = make_({directory, *header, job.order, unfinished}, should_continue);
  if (!build) {
    wait(job, build.error());
  } else if (ours && !build->stopped && build->verdict.ready) {
    return finish(job, unfinished, *build);
  } else if (ours) {
    settle(job, *build);
  }
  fs::remove(unfinished, error);
}

void ExportWorker::settle(const ExportJob& job, const Build& build) {
  if (build.stopped) {
    (void)jobs_.put_back(job, {}, false, false);
  } else if (build.killed || build.no_memory || build.delayed) {
    log::warning("export_retried", {{"export", job.id}, {"attempts", job.attempts + 1}});
    (void)jobs_.put_back(job, options_.first_pause * 4, false, true);
  } else {
    const Verdict verdict = of_export(build.verdict);
    log::info("export_refused",
              {{"export", job.id}, {"data_set", job.data_set_id}, {"result", verdict.code}});
    (void)jobs_.fail_with(job, verdict.code, verdict.text);
  }
}

void ExportWorker::finish(const ExportJob& job, const std::string& unfinished, const Build& build) {
  const std::string path = options_.export_dir + "/" + job.id + ".scan";
  std::error_code error;
  // With a fresh lease, nobody else renames their file meanwhile.
  const auto held = jobs_.renew(job);
  if (!held || !*held) {
    fs::remove(unfinished, error);
    return;
  }
  fs::rename(unfinished, path, error);
  if (error) {
    fs::remove(unfinished, error);
    return wait(job, {ErrorCode::kUnavailable, "cannot rename the export", {}});
  }
  const auto done = jobs_.finish(job, build.written);
  // If the outcome is unknown, the export may be ready. If it is gone instead, api sweeps the file.
  if (!done) return;
  if (!*done) {
    fs::remove(path, error);
    return;
  }
  log::info("export_done", {{"export", job.id},
                            {"data_set", job.data_set_id},
                            {"bytes", build.written},
                            {"seconds", build.seconds},
                            {"peak_mb", static_cast<double>(build.peak_bytes) / (1 << 20)}});
}

}  // namespace diaphane::ingest
