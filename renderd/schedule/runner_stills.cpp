// Stills: pictures without a session, which the runner renders beside the sessions.
#include <algorithm>

#include "renderd/schedule/runner_parts.h"

namespace diaphane::render {

// Drops cancelled stills early, because each holds the memory of a film.
void Runner::drop_cancelled_stills() {
  if (still_under_way_) return;
  std::erase_if(stills_,
                [](const auto& still) { return still->job.cancelled && still->job.cancelled(); });
}

bool Runner::begin_still() {
  if (still_under_way_) return false;
  drop_cancelled_stills();
  if (stills_.empty() || !still_may_run(stills_.front()->job.rank, moving_)) return false;
  auto item = std::make_unique<WorkItem>();
  item->still = stills_.front();
  // The first quantum is one sample. Later ones fit the time that is due at the speed measured so
  // far.
  const PendingStill& still = *item->still;
  const Progress before = still.samples > 0 ? still.job.renderer->progress() : Progress{};
  const double per_sample = before.samples > 0 ? before.seconds / double(before.samples) : 0;
  const double due = std::max(still_seconds_due_, kStillQuantumSeconds);
  const auto left = still.job.samples - std::min<std::uint64_t>(still.job.samples, still.samples);
  item->samples = samples_within(due, per_sample, std::max<std::uint64_t>(left, 1));
  begin(std::move(item));
  return true;
}

void Runner::carry_out_still(WorkItem& item, ProgressMonitor::Work& work) {
  render_still(item, work);
  // Finishing a large picture takes a second on the CPU, so quanta of sessions may run meanwhile.
  rendered(item);
  if (!item.failed) finish_still(item, work);
}

void Runner::render_still(WorkItem& item, ProgressMonitor::Work& work) {
  StillJob& job = item.still->job;
  const Time start = clock_.now();
  const double before = own_seconds(item);
  if (!item.still->prepared) {
    job.renderer->prepare_denoising(job.smoothed);
    if (const auto taken = set_scene(*job.renderer, job.volume, *job.scene, job.canvas); !taken) {
      item.failed = taken.error();
      return;
    }
    item.still->prepared = true;
  }
  const auto batch = job.renderer->render(item.samples, [&] {
    work.heartbeat();
    return stopping_ || !still_may_run(job.rank, moving_) || (job.cancelled && job.cancelled());
  });
  item.render_seconds = seconds_between(start, clock_.now());
  if (batch && job.took) job.took(own_seconds(item) - before + batch->helped_seconds);
  if (!batch) {
    item.failed = batch.error();
    return;
  }
  item.still->samples += batch->samples;
}

void Runner::finish_still(WorkItem& item, ProgressMonitor::Work& work) {
  StillJob& job = item.still->job;
  const StillSoFar so_far{item.still->samples, job.samples, job.renderer->progress().error,
                          job.error, clock_.now() >= job.until};
  if (!still_is_rendered(so_far) || (job.cancelled && job.cancelled())) return;
  work.heartbeat();
  const Time start = clock_.now();
  PictureRgb8& picture = item.made.emplace();
  const Result<bool> shown = job.smoothed
                                 ? job.renderer->display_denoised(picture)
                                 : job.renderer->display(picture).map([] { return false; });
  item.picture_seconds = seconds_between(start, clock_.now());
  if (!shown) item.failed = shown.error();
}

void Runner::settle_still(WorkItem& item) {
  still_under_way_ = false;
  StillJob& job = item.still->job;
  still_seconds_due_ =
      still_due_after(job.rank, still_seconds_due_, item.render_seconds + item.picture_seconds);
  if (!item.failed && !item.made) return;
  // A job may have been cancelled while its picture was made.
  if (!job.cancelled || !job.cancelled()) {
    if (item.failed) {
      job.done(tl::unexpected(*item.failed), 0);
    } else {
      job.done(std::move(*item.made), job.renderer->progress().error);
    }
  }
  std::erase(stills_, item.still);  // a still of a higher rank may have been inserted before it
  if (item.failed && item.failed->code == ErrorCode::kDeviceLost && options_.device_lost) {
    options_.device_lost(*item.failed);
  }
}

}  // namespace diaphane::render
