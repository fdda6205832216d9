#include "renderd/schedule/runner.h"

#include <algorithm>
#include <optional>

#include "renderd/schedule/canvas.h"

namespace diaphane::render {
namespace {

using Seconds = std::chrono::duration<double>;

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

// A session on this device. All but `gone` belongs to the runner's thread, and during a round to
// the lane that has its turn.
struct Runner::Track {
  explicit Track(std::uint64_t first_epoch) : ledger(first_epoch) {}

  std::uint64_t handle = 0;
  std::shared_ptr<RenderClient> client;
  std::unique_ptr<FrameRenderer> renderer;
  std::atomic<bool> gone{false};
  Ledger ledger;
};

// One quantum of a round, and what came of it.
struct Runner::Turn {
  std::shared_ptr<Track> track;
  std::uint32_t samples = 0;
  double fill = 1;
  double scene_seconds = 0;
  std::optional<Error> refused;
  std::optional<Result<Batch>> batch;
  Progress progress;
};

Runner::Runner(std::unique_ptr<Policy> policy, const Clock& clock, Options options)
    : policy_(std::move(policy)),
      clock_(clock),
      options_(std::move(options)),
      lanes_(options_.lanes) {
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
  auto track = std::make_shared<Track>(first_epoch);
  track->client = std::move(client);
  track->renderer = std::move(renderer);
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
    const Time since = clock_.now();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, next_rest(), [&] { return wakes_ != seen; });
    spent_.idle += seconds_between(since, clock_.now());
  }
  adopt();
  tell_times();
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
    const Wanted& wanted = track->ledger.wanted();
    if (!track->ledger.moving() || !wanted.visible) continue;
    const Seconds rest = Seconds(kRestSeconds) - (now - wanted.last_input);
    wait = std::min(wait, std::chrono::duration_cast<std::chrono::nanoseconds>(
                              std::max(rest, Seconds(0)) + std::chrono::milliseconds(1)));
  }
  return wait;
}

void Runner::tell_times() {
  const std::lock_guard lock(mutex_);
  told_ = spent_;
}

RunnerTimes Runner::times() const {
  const std::lock_guard lock(mutex_);
  return told_;
}

// Of everybody, what is wanted now; what is due is shown.
std::vector<SessionView> Runner::look(Time now) {
  std::vector<SessionView> views;
  views.reserve(tracks_.size());
  bool anybody_moves = false;
  for (const auto& track : tracks_) {
    Ledger& ledger = track->ledger;
    ledger.refresh(track->client->wanted(), costs_, options_.rules, now);
    emit_if_due(*track, now);
    if (!ledger.wanted().scene || track->gone) continue;
    views.push_back(ledger.view(track->handle, costs_, options_.rules, now));
    anybody_moves = anybody_moves || (ledger.moving() && ledger.wanted().visible);
  }
  still_share_ = anybody_moves ? kStillShareMoving : kStillShare;
  return views;
}

bool Runner::step() {
  const Time now = clock_.now();
  const double pictures = spent_.pictures;
  const std::vector<SessionView> views = look(now);
  const Time looked = clock_.now();
  // Pictures are no loss: somebody sees them.
  spent_.deciding += seconds_between(now, looked) - (spent_.pictures - pictures);
  if (still_seconds_due_ >= kStillQuantumSeconds && still_quantum()) return true;
  const Time asked = clock_.now();
  const std::vector<Quantum> quanta = policy_->next(views);
  const double decided = seconds_between(asked, clock_.now());
  spent_.policy += decided;
  spent_.deciding += decided;
  tell_times();
  return quanta.empty() ? still_quantum() : round(quanta);
}

bool Runner::round(const std::vector<Quantum>& quanta) {
  std::vector<Turn> turns;
  std::vector<std::uint64_t> handles;
  double filled = 0;
  for (const Quantum& quantum : quanta) {
    const auto chosen = std::find_if(tracks_.begin(), tracks_.end(), [&](const auto& track) {
      return track->handle == quantum.session;
    });
    if (chosen == tracks_.end()) continue;
    Turn turn;
    turn.track = *chosen;
    turn.samples = quantum.samples;
    const double parallel = options_.rules.device_parallel;
    const Canvas canvas = turn.track->ledger.planned();
    const double work = double(canvas.width) * canvas.height * quantum.samples;
    turn.fill = parallel > 0 ? std::min(1.0, work / parallel) : 1;
    filled += turn.fill;
    handles.push_back(quantum.session);
    turns.push_back(std::move(turn));
  }
  if (turns.empty()) return false;
  std::sort(handles.begin(), handles.end());
  const Time start = clock_.now();
  lanes_.run(turns.size(), [&](std::size_t i) { carry_out(turns[i]); });
  const double seconds = seconds_between(start, clock_.now());
  double scenes = 0;
  double all = 0;
  for (Turn& turn : turns) {
    scenes += turn.scene_seconds;
    all += turn.scene_seconds + (turn.batch && *turn.batch ? (*turn.batch)->seconds : 0);
    // What a sample costs alone: those that share a full device wait for each other.
    settle(turn, turns.size() > 1 ? std::min(1.0, 1 / filled) : 1);
  }
  const double scene_share = all > 0 ? seconds * scenes / all : 0;
  spent_.scenes += scene_share;
  spent_.rendering += seconds - scene_share;
  ++spent_.rounds;
  spent_.quanta += turns.size();
  spent_.switches += handles != last_round_;
  last_round_ = std::move(handles);
  busy(seconds - scene_share);
  return true;
}

// In a lane: the renderer alone, and whether newer input came.
void Runner::carry_out(Turn& turn) const {
  Track& track = *turn.track;
  Ledger& ledger = track.ledger;
  if (ledger.stale()) {
    const Time start = clock_.now();
    track.renderer->prepare_denoising(!ledger.wanted().raw);
    auto taken = track.renderer->set_scene(*ledger.wanted().scene, ledger.planned());
    turn.scene_seconds = seconds_between(start, clock_.now());
    if (!taken) {
      turn.refused = std::move(taken.error());
      return;
    }
    ledger.began(turn.scene_seconds, clock_.now());
    track.client->began(ledger.epoch(), ledger.wanted());
  }
  const bool interruptible = ledger.interruptible();
  const auto stop = [&] {
    if (stopping_ || track.gone) return true;
    return interruptible && track.client->version() != ledger.applied_version();
  };
  turn.batch = track.renderer->render(turn.samples, stop);
  turn.progress = track.renderer->progress();
}

// `share`: of the seconds that the quantum took, those that were its own.
void Runner::settle(Turn& turn, double share) {
  Track& track = *turn.track;
  if (turn.refused) {
    if (!track.ledger.has_picture()) return drop(track, *turn.refused);
    track.ledger.refused();
    track.client->refused(track.ledger.wanted(), *turn.refused);
    return;
  }
  if (!*turn.batch) return drop(track, turn.batch->error());
  const Batch& batch = **turn.batch;
  Batch alone = batch;
  alone.seconds *= share;
  track.ledger.rendered(alone, turn.progress, costs_, clock_.now());
  if (!track.gone) track.client->rendered(batch);
}

void Runner::busy(double seconds) {
  busy_seconds_ = busy_seconds_ + seconds;
  still_seconds_due_ = std::min(still_seconds_due_ + still_share_ * seconds, kLongestStillSeconds);
}

void Runner::emit_if_due(Track& track, Time now) {
  Ledger& ledger = track.ledger;
  if (track.gone) return;
  const auto question = ledger.emission(options_.rules, now);
  if (!question || !should_emit(*question)) return;

  const Time start = clock_.now();
  RenderedPicture rendered;
  // The last picture is what the samples say and nothing else.
  const Result<bool> shown =
      question->converged ? track.renderer->display(rendered.picture).map([] { return false; })
                          : track.renderer->display_denoised(rendered.picture);
  if (!shown) return drop(track, shown.error());
  rendered.info.epoch = ledger.epoch();
  // An update that changed nothing is answered by the same picture under its own number.
  rendered.info.input_seq = ledger.stale() ? ledger.input_seq() : ledger.wanted().input_seq;
  rendered.info.samples = ledger.progress().samples;
  rendered.info.error = ledger.progress().error;
  rendered.info.render_us = static_cast<std::uint64_t>(ledger.progress().seconds * 1e6);
  rendered.info.first_of_epoch = ledger.samples_shown() == 0;
  rendered.info.moving = ledger.moving();
  rendered.info.converged = question->converged;
  rendered.info.denoised = *shown;
  const double seconds = seconds_between(start, clock_.now());
  spent_.pictures += seconds;
  ledger.shown(seconds, costs_, now);
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
