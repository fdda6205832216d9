// The part of the worker that anonymises by permanently removing what is outside the kept region.
#include <filesystem>

#include "common/log.h"
#include "common/try.h"
#include "ingest/head/find_head.h"
#include "ingest/pipeline/worker.h"
#include "volume/region.h"
#include "volume/store.h"

namespace diaphane::ingest {

void Worker::work_cut(const Job& job) {
  const CutOrder& order = *job.cut;
  log::info("cut_started", {{"data_set", job.data_set_id},
                            {"killed", job.attempts},
                            {"interrupted", job.interruptions}});
  const auto header = volume::read_header(volume_path(job));
  if (!header && header.error().code == ErrorCode::kUnavailable) return wait(job, header.error());
  if (!header) return refuse_cut(job, "The stored scan cannot be read.");
  if (!order.result.empty() && header->content_hash == order.result) {
    // If an earlier attempt was ended after the exchange, the old volume may remain under another
    // name.
    (void)volume::sweep_unfinished(options_.volume_dir);
    const auto left = volume::read(volume_path(job), false);
    if (!left) return wait(job, left.error());
    return finish_cut(job, *left);
  }
  if (header->content_hash != order.of) {
    return refuse_cut(job, "The scan has changed since you reviewed it. Nothing was removed.");
  }
  if (job.attempts >= options_.most_attempts) {
    return refuse_cut(job, "The server ran out of memory or time each time. Nothing was removed.");
  }
  const auto plan = volume::plan_cut(*header, order.region);
  if (!plan) return refuse_cut(job, "Too little of the scan would remain. Nothing was removed.");

  Hold hold = Hold::kOurs;
  auto build = builder_.cut({volume_path(job), *header, order.region}, keep_going(job, hold));
  if (!build) return wait(job, build.error());
  if (hold != Hold::kOurs) return;
  if (build->stopped) return give_back(job);
  if (build->killed || build->no_memory || build->delayed) return retry(job, *build);
  if (!build->verdict.ready) return refuse_cut(job, build->verdict.text + " Nothing was removed.");

  const auto replaced = volume::replace(build->volume, volume_path(job), [&]() -> Result<void> {
    const std::string& hash = build->volume.header.content_hash;
    const auto noted = insist([&] { return jobs_.note_cut(job, hash, plan->shift); });
    DIAPHANE_TRY(noted);
    if (*noted != Hold::kOurs)
      return fail(ErrorCode::kConflict, "another worker has taken over the job");
    return {};
  });
  if (!replaced) {
    if (replaced.error().code == ErrorCode::kConflict) return;  // another worker has the job now
    return wait(job, replaced.error());
  }
  events_.built(build->seconds, build->peak_bytes);
  finish_cut(job, build->volume);
}

void Worker::finish_cut(const Job& job, const volume::Volume& volume) {
  const volume::Header& header = volume.header;
  const std::string head = to_json(find_head(volume));
  const std::uint64_t bytes = header.total_voxel_count() * sizeof(std::int16_t);
  const auto hold = insist([&] { return jobs_.finish_cut(job, header, bytes, head); });
  if (!hold) return;  // stopping while Postgres is unavailable; the job is resumed later
  if (*hold == Hold::kDeleted) return discard_volume(job);
  if (*hold == Hold::kLost) return;
  log::info("cut_done", {{"data_set", job.data_set_id}, {"voxels", header.total_voxel_count()}});
  events_.done("cut");
}

void Worker::refuse_cut(const Job& job, const std::string& text) {
  const auto hold = insist([&] { return jobs_.finish_cut_refused(job, text); });
  if (!hold || *hold != Hold::kOurs) return;
  log::warning("cut_refused", {{"data_set", job.data_set_id}});
  events_.done("cut_refused");
}

}  // namespace diaphane::ingest
