#include "renderd/schedule/runner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "renderd/schedule/canvas.h"
#include "renderd/schedule/emission.h"

namespace diaphane::render {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kUnknownError = std::numeric_limits<double>::infinity();

double pixels(Canvas canvas) { return double(canvas.width) * double(canvas.height); }

double seconds_between(std::chrono::steady_clock::time_point from,
                       std::chrono::steady_clock::time_point to) {
  return Seconds(to - from).count();
}

// The stills' time for each second that sessions rendered: little while somebody drags, else a
// third of the device. By time, not by turns: a sample of a large canvas on a slow device takes a
// second, and a turn of 30 ms between two of them would let a thumbnail wait for a minute.
constexpr double kStillShareMoving = 1.0 / 16;
constexpr double kStillShare = 0.5;
constexpr double kStillQuantumSeconds = 0.03;
constexpr double kLongestStillSeconds = 0.25;

}  // namespace

bool may_interrupt(bool began_moving, bool shown) { return shown || !began_moving; }

// A session on this device. All but `gone` belongs to the runner's thread.
struct Runner::Track {
  std::uint64_t handle = 0;
  std::shared_ptr<RenderClient> client;
  std::unique_ptr<FrameRenderer> renderer;
  std::atomic<bool> gone{false};

  Wanted wanted;
  bool moving = false;
  Canvas planned;

  // What the film holds.
  std::optional<std::uint64_t> applied_version;
  Canvas canvas;                       // of the film
  std::optional<Canvas> refused_size;  // at this version: not tried again
  bool began_moving = false;
  std::uint64_t epoch = 0;
  std::uint64_t input_seq = 0;
  Progress progress;
  double seconds_per_pixel = 0;

  // What was shown of it.
  std::uint64_t samples_shown = 0;
  bool shown_moving = false;
  Time shown_at{};

  bool stale() const {
    return wanted.scene && (applied_version != wanted.version || planned != canvas);
  }
};

Runner::Runner(std::unique_ptr<Policy> policy, const Clock& clock, Options options)
    : policy_(std::move(policy)), clock_(clock), options_(std::move(options)) {
  thread_ = std::thread([this] { run(); });
}

Runner::~Runner() { stop(); }

void Runner::stop() {
  stopping_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

std::uint64_t Runner::add(std::shared_ptr<RenderClient> client,
                          std::unique_ptr<FrameRenderer> renderer, std::uint64_t first_epoch) {
  auto track = std::make_shared<Track>();
  track->client = std::move(client);
  track->renderer = std::move(renderer);
  track->epoch = first_epoch;
  std::uint64_t handle = 0;
  {
    const std::lock_guard lock(mutex_);
    handle = track->handle = next_handle_++;
    known_.push_back(track);
    arriving_.push_back(std::move(track));
    ++wakes_;
  }
  changed_.notify_one();
  return handle;
}

void Runner::remove(std::uint64_t handle) {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& track : known_) {
      if (track->handle == handle) track->gone = true;
    }
    ++wakes_;
  }
  changed_.notify_one();
}

void Runner::wake() {
  {
    const std::lock_guard lock(mutex_);
    ++wakes_;
  }
  changed_.notify_one();
}

void Runner::submit(StillJob job) {
  {
    const std::lock_guard lock(mutex_);
    arriving_stills_.push_back(std::move(job));
    ++wakes_;
  }
  changed_.notify_one();
}

void Runner::run() {
  while (!stopping_) {
    std::uint64_t seen = 0;
    {
      const std::lock_guard lock(mutex_);
      seen = wakes_;
    }
    adopt();
    if (step()) continue;
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, next_rest(), [&] { return wakes_ != seen; });
  }
  adopt();
  for (StillJob& job : stills_) {
    job.done(fail(ErrorCode::kUnavailable, "The render server is stopping."), 0);
  }
}

void Runner::adopt() {
  std::vector<std::shared_ptr<Track>> leaving;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  for (auto& track : arriving_) tracks_.push_back(std::move(track));
  arriving_.clear();
  for (StillJob& job : arriving_stills_) stills_.push_back(std::move(job));
  arriving_stills_.clear();
  const auto gone = [](const std::shared_ptr<Track>& track) { return track->gone.load(); };
  std::copy_if(tracks_.begin(), tracks_.end(), std::back_inserter(leaving), gone);
  std::erase_if(tracks_, gone);
  std::erase_if(known_, gone);
}

// How long until something happens by itself: a moving session comes to rest.
std::chrono::nanoseconds Runner::next_rest() const {
  const Time now = clock_.now();
  std::chrono::nanoseconds wait = std::chrono::seconds(1);
  for (const auto& track : tracks_) {
    if (!track->moving || !track->wanted.visible) continue;
    const Seconds rest = Seconds(kRestSeconds) - (now - track->wanted.last_input);
    wait = std::min(wait, std::chrono::duration_cast<std::chrono::nanoseconds>(
                              std::max(rest, Seconds(0)) + std::chrono::milliseconds(1)));
  }
  return wait;
}

bool Runner::step() {
  const Time now = clock_.now();
  for (const auto& track : tracks_) {
    refresh(*track, now);
    emit_if_due(*track, now);
  }
  std::vector<SessionView> views;
  views.reserve(tracks_.size());
  bool anybody_moves = false;
  for (const auto& track : tracks_) {
    if (!track->wanted.scene || track->gone) continue;
    views.push_back(view_of(*track, now));
    anybody_moves = anybody_moves || (track->moving && track->wanted.visible);
  }
  still_share_ = anybody_moves ? kStillShareMoving : kStillShare;
  if (still_seconds_due_ >= kStillQuantumSeconds && still_quantum()) return true;
  const std::optional<Quantum> next = policy_->next(views);
  if (!next) return still_quantum();
  const auto chosen = std::find_if(tracks_.begin(), tracks_.end(), [&](const auto& track) {
    return track->handle == next->session;
  });
  if (chosen == tracks_.end()) return false;
  const std::shared_ptr<Track> track = *chosen;
  if (track->stale()) apply_wanted(*track);
  if (track->applied_version && !track->gone) quantum(*track, next->samples);
  return true;
}

void Runner::refresh(Track& track, Time now) {
  track.wanted = track.client->wanted();
  track.moving = seconds_between(track.wanted.last_input, now) < kRestSeconds;
  if (track.applied_version != track.wanted.version) track.refused_size.reset();
  // In mid-gesture a size is chosen with each new scene only: what is there goes on converging.
  if (track.moving && track.applied_version == track.wanted.version) {
    track.planned = track.canvas;
    return;
  }
  track.planned =
      plan_canvas({track.wanted.viewport, track.canvas, seconds_per_pixel(track), track.moving});
  if (track.refused_size == track.planned) track.planned = track.canvas;
}

// Until a session was measured itself, it costs what the last one cost.
double Runner::seconds_per_pixel(const Track& track) const {
  return track.seconds_per_pixel > 0 ? track.seconds_per_pixel : seconds_per_pixel_;
}

SessionView Runner::view_of(const Track& track, Time now) const {
  SessionView view;
  view.session = track.handle;
  view.samples = track.stale() ? 0 : track.progress.samples;
  view.error = track.stale() ? kUnknownError : converged(track) ? 0 : track.progress.error;
  // Not trusted yet: not converged, whatever it says.
  if (!track.stale() && !converged(track))
    view.error = std::max(view.error, 2 * options_.target_error);
  view.target_error = options_.target_error;
  view.seconds_per_sample = seconds_per_pixel(track) * pixels(track.planned);
  view.seconds_since_input = seconds_between(track.wanted.last_input, now);
  view.seconds_since_frame = seconds_between(track.shown_at, now);
  view.visible = track.wanted.visible;
  view.wants_frame = track.wanted.room;
  return view;
}

bool Runner::converged(const Track& track) const {
  if (track.progress.samples >= options_.most_samples) return true;
  return track.progress.samples >= options_.fewest_samples &&
         track.progress.error <= options_.target_error;
}

void Runner::apply_wanted(Track& track) {
  const auto refused = [&](const Error& why) {
    if (!track.applied_version) return drop(track, why);
    // The picture stays; neither this scene nor this size is tried again.
    track.applied_version = track.wanted.version;
    track.refused_size = track.planned;
    track.planned = track.canvas;
    track.client->refused(track.wanted, why);
  };
  track.renderer->prepare_denoising(!track.wanted.raw);
  auto taken = track.renderer->set_scene(*track.wanted.scene, track.planned);
  if (!taken) return refused(taken.error());
  track.applied_version = track.wanted.version;
  track.canvas = track.planned;
  track.began_moving = track.moving;
  track.input_seq = track.wanted.input_seq;
  track.progress = {};
  track.progress.error = kUnknownError;
  track.samples_shown = 0;
  ++track.epoch;
  track.client->began(track.epoch, track.wanted);
}

void Runner::quantum(Track& track, std::uint32_t samples) {
  const bool interruptible = may_interrupt(track.began_moving, track.samples_shown > 0);
  const auto stop = [&] {
    if (stopping_ || track.gone) return true;
    return interruptible && track.client->version() != *track.applied_version;
  };
  const auto batch = track.renderer->render(samples, stop);
  if (!batch) return drop(track, batch.error());
  busy_seconds_ = busy_seconds_ + batch->seconds;
  still_seconds_due_ =
      std::min(still_seconds_due_ + still_share_ * batch->seconds, kLongestStillSeconds);
  if (batch->samples > 0) {
    const double cost = batch->seconds / (batch->samples * pixels(track.canvas));
    // The first sample of an epoch pays for set-up; a mean over a few forgets it soon.
    track.seconds_per_pixel =
        track.seconds_per_pixel > 0 ? 0.6 * track.seconds_per_pixel + 0.4 * cost : cost;
    seconds_per_pixel_ = track.seconds_per_pixel;
  }
  track.progress = track.renderer->progress();
  if (!track.gone) track.client->rendered(*batch);
}

void Runner::emit_if_due(Track& track, Time now) {
  if (!track.applied_version || track.gone || !track.wanted.visible) return;
  EmissionQuestion question;
  question.samples = track.progress.samples;
  question.samples_shown = track.samples_shown;
  question.seconds_since_frame = seconds_between(track.shown_at, now);
  question.moving = track.moving;
  question.shown_moving = track.shown_moving;
  question.converged = converged(track);
  question.wanted_again = track.wanted.picture_again && !track.stale();
  question.room = track.wanted.room;
  // A picture that is about to be replaced is shown only if nothing was shown of it yet.
  if (track.stale() && track.samples_shown > 0) return;
  if (!should_emit(question)) return;

  RenderedPicture rendered;
  // The last picture is what the samples say and nothing else.
  const Result<bool> shown =
      question.converged ? track.renderer->display(rendered.picture).map([] { return false; })
                         : track.renderer->display_denoised(rendered.picture);
  if (!shown) return drop(track, shown.error());
  rendered.info.epoch = track.epoch;
  // An update that changed nothing is answered by the same picture under its own number.
  rendered.info.input_seq = track.stale() ? track.input_seq : track.wanted.input_seq;
  rendered.info.samples = track.progress.samples;
  rendered.info.error = track.progress.error;
  rendered.info.render_us = static_cast<std::uint64_t>(track.progress.seconds * 1e6);
  rendered.info.first_of_epoch = track.samples_shown == 0;
  rendered.info.moving = track.moving;
  rendered.info.converged = question.converged;
  rendered.info.denoised = *shown;
  track.samples_shown = track.progress.samples;
  track.shown_moving = track.moving;
  track.shown_at = now;
  track.client->picture(std::move(rendered));
}

bool Runner::still_quantum() {
  while (!stills_.empty() && stills_.front().cancelled && stills_.front().cancelled()) {
    stills_.pop_front();
    still_samples_ = 0;
  }
  if (stills_.empty()) return false;
  StillJob& job = stills_.front();
  const auto end = [&](Result<PictureRgb8> picture, double error) {
    job.done(std::move(picture), error);
    stills_.pop_front();
    still_samples_ = 0;
  };
  if (still_samples_ == 0) {
    if (const auto taken = job.renderer->set_scene(*job.scene, job.canvas); !taken) {
      end(tl::unexpected(taken.error()), 0);
      return true;
    }
  }
  // One sample, then as many as fit what is due at the speed seen so far.
  const Progress before = job.renderer->progress();
  const double per_sample = before.samples > 0 ? before.seconds / double(before.samples) : 0;
  const double due = std::max(still_seconds_due_, kStillQuantumSeconds);
  const double fitting = per_sample > 0 ? due / per_sample : 1;
  const auto left = job.samples - std::min<std::uint64_t>(job.samples, still_samples_);
  const auto samples = static_cast<std::uint32_t>(
      std::clamp<double>(fitting, 1, static_cast<double>(std::max<std::uint64_t>(left, 1))));
  const auto batch = job.renderer->render(samples, [this] { return stopping_.load(); });
  if (!batch) {
    const Error& why = batch.error();
    end(tl::unexpected(why), 0);
    if (why.code == ErrorCode::kDeviceLost && options_.device_lost) options_.device_lost(why);
    return true;
  }
  busy_seconds_ = busy_seconds_ + batch->seconds;
  still_seconds_due_ = std::max(0.0, still_seconds_due_ - batch->seconds);
  still_samples_ += batch->samples;
  const bool late = still_samples_ > 0 && clock_.now() >= job.until;
  if (still_samples_ < job.samples && !late) return true;
  PictureRgb8 picture;
  if (const auto shown = job.renderer->display(picture); !shown) {
    end(tl::unexpected(shown.error()), 0);
  } else {
    end(std::move(picture), job.renderer->progress().error);
  }
  return true;
}

void Runner::drop(Track& track, const Error& why) {
  track.gone = true;
  track.client->failed(why);
  if (why.code == ErrorCode::kDeviceLost && options_.device_lost) options_.device_lost(why);
}

}  // namespace diaphane::render
