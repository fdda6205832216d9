// Stills: pictures without a session, which the runner renders beside the sessions.
#include <algorithm>

#include "renderd/schedule/runner_parts.h"

namespace diaphane::render {

// A cancelled still is dropped early because it holds the memory of a film.
void Runner::drop_cancelled_stills() {
  if (still_under_way_) return;
  std::erase_if(stills_,
                [](const auto& still) { return still->job.cancelled && still->job.cancelled(); });
}

bool Runner::begin_still() {
  if (still_under_way_) return false;
  drop_cancelled_stills();
  if (stills_.empty() || !still_may_run(stills_.front()->job.rank, moving_)) return false;
  auto turn = std::make_unique<Turn>();
  turn->still = stills_.front();
  // The first quantum is one sample. Later ones fit the time that is due at the speed measured so
  // far.
  const Still& still = *turn->still;
  const Progress before = still.samples > 0 ? still.job.renderer->progress() : Progress{};
  const double per_sample = before.samples > 0 ? before.seconds / double(before.samples) : 0;
  const double due = std::max(still_seconds_due_, kStillQuantumSeconds);
  const auto left = still.job.samples - std::min<std::uint64_t>(still.job.samples, still.samples);
  turn->samples = samples_within(due, per_sample, std::max<std::uint64_t>(left, 1));
  begin(std::move(turn));
  return true;
}

void Runner::carry_out_still(Turn& turn, Signs::Work& signs) {
  render_still(turn, signs);
  // Finishing a large picture takes a second on the CPU, so quanta of sessions may run meanwhile.
  rendered(turn);
  if (!turn.failed) finish_still(turn, signs);
}

void Runner::render_still(Turn& turn, Signs::Work& signs) {
  StillJob& job = turn.still->job;
  const Time start = clock_.now();
  const double before = own_seconds(turn);
  if (turn.still->samples == 0) {
    job.renderer->prepare_denoising(job.smoothed);
    if (const auto taken = job.renderer->set_scene(*job.scene, job.canvas); !taken) {
      turn.failed = taken.error();
      return;
    }
  }
  const auto batch = job.renderer->render(turn.samples, [&] {
    signs.alive();
    return stopping_ || !still_may_run(job.rank, moving_) || (job.cancelled && job.cancelled());
  });
  turn.render_seconds = seconds_between(start, clock_.now());
  if (batch && job.took) job.took(own_seconds(turn) - before + batch->helped_seconds);
  if (!batch) {
    turn.failed = batch.error();
    return;
  }
  turn.still->samples += batch->samples;
}

void Runner::finish_still(Turn& turn, Signs::Work& signs) {
  StillJob& job = turn.still->job;
  const StillSoFar so_far{turn.still->samples, job.samples, job.renderer->progress().error,
                          job.error, clock_.now() >= job.until};
  if (!still_is_rendered(so_far) || (job.cancelled && job.cancelled())) return;
  signs.alive();
  const Time start = clock_.now();
  PictureRgb8& picture = turn.made.emplace();
  const Result<bool> shown = job.smoothed
                                 ? job.renderer->display_denoised(picture)
                                 : job.renderer->display(picture).map([] { return false; });
  turn.picture_seconds = seconds_between(start, clock_.now());
  if (!shown) turn.failed = shown.error();
}

void Runner::settle_still(Turn& turn) {
  still_under_way_ = false;
  StillJob& job = turn.still->job;
  still_seconds_due_ =
      still_due_after(job.rank, still_seconds_due_, turn.render_seconds + turn.picture_seconds);
  if (!turn.failed && !turn.made) return;
  // A job may have been cancelled while its picture was made.
  if (!job.cancelled || !job.cancelled()) {
    if (turn.failed) {
      job.done(tl::unexpected(*turn.failed), 0);
    } else {
      job.done(std::move(*turn.made), job.renderer->progress().error);
    }
  }
  std::erase(stills_, turn.still);  // a still of a higher rank may have been inserted before it
  if (turn.failed && turn.failed->code == ErrorCode::kDeviceLost && options_.device_lost) {
    options_.device_lost(*turn.failed);
  }
}

}  // namespace diaphane::render
