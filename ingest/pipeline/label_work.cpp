// The part of the worker that adds labels to a scan that is ready.
#include "common/log.h"
#include "ingest/pipeline/worker.h"
#include "volume/store.h"

namespace diaphane::ingest {

void Worker::work_labels(const Job& job) {
  log::info("labels_started", {{"data_set", job.data_set_id},
                               {"killed", job.attempts},
                               {"interrupted", job.interruptions}});
  const auto header = volume::read_header(volume_path(job));
  if (!header && header.error().code == ErrorCode::kUnavailable) return wait(job, header.error());
  if (!header) return refuse_labels(job, "internal", "The stored scan cannot be read.");
  if (job.attempts >= options_.most_attempts) {
    return refuse_labels(job, "no_memory",
                         "The server ran out of memory or time each time it read these labels.");
  }
  Hold hold = Hold::kOurs;
  const auto build = builder_.place_labels({upload_path(job), *header}, keep_going(job, hold));
  if (!build) return wait(job, build.error());
  if (hold != Hold::kOurs) {
    if (hold == Hold::kDeleted) remove_original(job);
    return;
  }
  if (build->stopped) return give_back(job);
  if (build->killed || build->no_memory || build->delayed) return retry(job, *build);
  if (build->file_missing) {
    if (job.waits < options_.most_waits_for_file) {
      return wait(job, WaitReason::kService, "the upload's file is missing", false);
    }
    return refuse_labels(job, "upload_gone",
                         "The upload is no longer available. Please upload the labels again.");
  }
  if (!build->verdict.ready) return refuse_labels(job, build->verdict.code, build->verdict.text);
  const std::uint64_t voxel_bytes = header->total_voxel_count() * sizeof(std::int16_t);
  if (job.quota_left && voxel_bytes + build->labels.size() > *job.quota_left) {
    return refuse_labels(job, "over_quota",
                         "Your storage has no room for these labels. Delete other scans, then add "
                         "the labels again.");
  }
  store_labels(job, *build);
}

void Worker::store_labels(const Job& job, const Build& build) {
  // Only a fresh lease permits writing to the volume's directory.
  const auto fresh = insist([&] { return jobs_.renew(job); });
  if (!fresh || *fresh != Hold::kOurs) {
    if (fresh && *fresh == Hold::kDeleted) remove_original(job);
    return;
  }
  if (auto stored = volume::write_label_set(build.labels, volume_path(job)); !stored) {
    return wait(job, stored.error());
  }
  const auto& set = build.volume.label_set;
  const auto hold = insist([&] { return jobs_.finish_labels(job, set, build.labels.size()); });
  if (!hold || *hold == Hold::kLost) return;
  if (*hold == Hold::kDeleted) {
    discard_volume(job);
    return remove_original(job);
  }
  log::info("labels_done", {{"data_set", job.data_set_id}, {"labels", set.table.size()}});
  events_.done("labels");
  remove_original(job);
}

void Worker::refuse_labels(const Job& job, const std::string& code, const std::string& text) {
  const auto hold = insist([&] { return jobs_.finish_labels_refused(job, code, text); });
  if (!hold || *hold == Hold::kLost) return;
  log::info("labels_refused", {{"data_set", job.data_set_id}, {"result", code}});
  events_.done("labels_refused");
  remove_original(job);
}

}  // namespace diaphane::ingest
