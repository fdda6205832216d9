#include "renderd/schedule/runner.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "renderd/schedule/canvas.h"
#include "renderd/schedule/runner_parts.h"

namespace diaphane::render {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kLongestStillSeconds = 0.25;

bool first_picture(const Ledger& ledger) { return ledger.stale() || ledger.samples_shown() == 0; }

}  // namespace

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
    collect();
    if (step()) continue;
    std::unique_lock lock(mutex_);
    const bool idle = in_flight_.count() == 0;
    const Time since = clock_.now();
    changed_.wait_for(lock, next_rest(), [&] { return wakes_ != seen; });
    if (idle) spent_.idle += seconds_between(since, clock_.now());
  }
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return in_flight_.count() == 0; });
  }
  adopt();
  collect();
  for (const auto& still : stills_) {
    still->job.done(fail(ErrorCode::kUnavailable, "The render worker is shutting down."), 0);
  }
}

void Runner::adopt() {
  std::vector<std::shared_ptr<Track>> leaving;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  for (auto& track : arriving_) tracks_.push_back(std::move(track));
  arriving_.clear();
  for (StillJob& job : arriving_stills_) {
    const auto before = std::find_if(stills_.begin(), stills_.end(),
                                     [&](const auto& still) { return still->job.rank > job.rank; });
    stills_.insert(before, std::make_shared<Still>(Still{std::move(job)}));
  }
  arriving_stills_.clear();
  const auto gone = [](const std::shared_ptr<Track>& track) { return track->gone.load(); };
  std::copy_if(tracks_.begin(), tracks_.end(), std::back_inserter(leaving), gone);
  std::erase_if(tracks_, gone);
  std::erase_if(known_, gone);
}

// Returns the time until the next moving session comes to rest, which is the only change that does
// not wake the thread.
std::chrono::nanoseconds Runner::next_rest() const {
  const Time now = clock_.now();
  std::chrono::nanoseconds wait = std::chrono::seconds(1);
  for (const auto& track : tracks_) {
    if (track->under_way) continue;
    const Wanted& wanted = track->ledger.wanted();
    if (!track->ledger.moving() || !wanted.visible) continue;
    const Seconds rest = Seconds(kRestSeconds) - (now - wanted.last_input);
    wait = std::min(wait, std::chrono::duration_cast<std::chrono::nanoseconds>(
                              std::max(rest, Seconds(0)) + std::chrono::milliseconds(1)));
  }
  return wait;
}

double Runner::busy_seconds() const {
  const std::lock_guard lock(mutex_);
  return in_flight_.busy_seconds(clock_.now());
}

RunnerTimes Runner::times() const {
  const std::lock_guard lock(mutex_);
  RunnerTimes times = spent_;
  times.busy = in_flight_.busy_seconds(clock_.now());
  return times;
}

// Accounts for the work that the lanes have finished.
void Runner::collect() {
  std::vector<std::unique_ptr<Turn>> ended;
  double busy = 0;
  {
    const std::lock_guard lock(mutex_);
    ended.swap(ended_);
    busy = in_flight_.busy_seconds(clock_.now());
    for (const auto& turn : ended) {
      spent_.scenes += turn->scene_seconds;
      spent_.rendering += turn->render_seconds;
      spent_.pictures += turn->picture_seconds;
    }
  }
  still_seconds_due_ =
      std::min(still_seconds_due_ + still_share_ * (busy - busy_told_), kLongestStillSeconds);
  busy_told_ = busy;
  for (const auto& turn : ended) turn->still ? settle_still(*turn) : settle(*turn);
}

void Runner::settle(Turn& turn) {
  Track& track = *turn.track;
  track.under_way = false;
  if (turn.failed) return drop(track, *turn.failed);
  if (!turn.refused) return;
  if (!track.ledger.has_picture()) return drop(track, *turn.refused);
  track.ledger.refused();
  track.client->refused(track.ledger.wanted(), *turn.refused);
}

// Reads the current request of every session, and begins pictures that are due although no samples
// are rendered.
std::vector<SessionView> Runner::look() {
  const Time now = clock_.now();
  DeviceCosts costs;
  {
    const std::lock_guard lock(mutex_);
    costs = costs_;
  }
  std::vector<SessionView> views;
  views.reserve(tracks_.size());
  std::size_t moving = 0;
  std::size_t waiting = 0;
  double error = 0;
  for (const auto& track : tracks_) {
    if (track->gone) continue;
    Ledger& ledger = track->ledger;
    if (!track->under_way) {
      ledger.refresh(track->client->wanted(), costs, options_.rules, now);
      track->seen = ledger.view(track->handle, costs, options_.rules, now);
      track->moving = ledger.moving() && ledger.wanted().visible;
      const auto question = ledger.emission(options_.rules, now);
      if (question && should_emit(*question)) {
        auto turn = std::make_unique<Turn>();
        turn->track = track;
        turn->question = question;
        turn->fill = 0;  // hardly uses the device
        begin(std::move(turn));
      }
      if (!ledger.wanted().scene) continue;
    }
    track->seen.under_way = track->under_way;
    track->seen.visitor = track->client->of_visitor();
    if (track->moving) ++moving;
    if (gains(track->seen) && !track->client->of_another_worker()) ++waiting;
    // A session without a first picture has an infinite error; it counts as 1.
    if (track->seen.visible) error += std::min(1.0, track->seen.error);
    views.push_back(track->seen);
  }
  error_ = error;
  moving_ = moving;
  waiting_ = waiting;
  drop_cancelled_stills();
  still_share_ =
      still_share(stills_.empty() ? StillRank::kAwaited : stills_.front()->job.rank, moving);
  const std::lock_guard lock(mutex_);
  costs_.moving_sessions = moving;
  return views;
}

bool Runner::step() {
  const Time start = clock_.now();
  const std::vector<SessionView> views = look();
  bool room = false;
  unsigned highest = 0;
  {
    const std::lock_guard lock(mutex_);
    spent_.deciding += seconds_between(start, clock_.now());
    room = room_for_another(in_flight_, options_.device_queues);
    highest = in_flight_.highest();
    if (!room && (options_.device_queues || highest == kHighestPrecedence)) return false;
  }
  if (room && still_seconds_due_ >= kStillQuantumSeconds && begin_still()) return true;
  const Time asked = clock_.now();
  const std::vector<Quantum> quanta =
      room ? policy_->next(views) : policy_->overtaking(views, highest);
  {
    const std::lock_guard lock(mutex_);
    const double decided = seconds_between(asked, clock_.now());
    spent_.policy += decided;
    spent_.deciding += decided;
  }
  for (const Quantum& quantum : quanta) {
    const auto chosen = std::find_if(tracks_.begin(), tracks_.end(), [&](const auto& track) {
      return track->handle == quantum.session;
    });
    if (chosen == tracks_.end()) continue;
    auto turn = std::make_unique<Turn>();
    turn->track = *chosen;
    turn->samples = quantum.samples;
    const Ledger& ledger = turn->track->ledger;
    if (!options_.device_queues && ledger.moving() && first_picture(ledger)) {
      turn->precedence = first_picture_precedence(turn->track->seen);
    }
    const double parallel = options_.rules.device_parallel;
    const Canvas canvas = ledger.planned();
    const double work = double(canvas.width) * canvas.height * quantum.samples;
    turn->fill = parallel > 0 ? std::min(1.0, work / parallel) : 1;
    begin(std::move(turn));
  }
  return quanta.empty() ? room && begin_still() : true;
}

void Runner::begin(std::unique_ptr<Turn> turn) {
  if (turn->track) turn->track->under_way = true;
  if (turn->still) still_under_way_ = true;
  {
    const std::lock_guard lock(mutex_);
    in_flight_.begin(turn->fill, clock_.now(), turn->precedence);
    if (turn->track && turn->samples > 0) {
      ++spent_.quanta;
      spent_.switches += last_ != turn->track->handle;
      last_ = turn->track->handle;
    }
  }
  // The closure owns the turn as a raw pointer, because std::function requires copyable closures.
  lanes_.start([this, turn = turn.release()] {
    std::unique_ptr<Turn> mine(turn);
    {
      Signs::Work signs(signs_);
      mine->still ? carry_out_still(*mine, signs) : carry_out(*mine, signs);
    }
    ended(std::move(mine));
  });
}

void Runner::ended(std::unique_ptr<Turn> turn) {
  rendered(*turn);
  // Notifies under the lock, because the runner may be destroyed once its last turn has ended.
  const std::lock_guard lock(mutex_);
  in_flight_.end(clock_.now(), turn->precedence);
  ended_.push_back(std::move(turn));
  ++wakes_;
  changed_.notify_one();
}

double Runner::own_seconds(const Turn& turn) const {
  const std::lock_guard lock(mutex_);
  return in_flight_.own_seconds(clock_.now(), turn.precedence);
}

void Runner::carry_out(Turn& turn, Signs::Work& signs) {
  if (turn.question) {
    if (!options_.device_queues) turn.track->renderer->set_precedence(0);
    return show(turn, *turn.question);
  }
  const bool there = render(turn, signs);
  // A device that queues continues with other quanta while the picture is made. On the CPU, the
  // picture is made by the threads that render.
  if (options_.device_queues) rendered(turn);
  if (there) show_if_due(turn);
}

void Runner::rendered(Turn& turn) {
  if (turn.fill == 0) return;
  const std::lock_guard lock(mutex_);
  in_flight_.rendered(std::exchange(turn.fill, 0), clock_.now());
  ++wakes_;
  changed_.notify_one();
}

// Prepares the requested scene if it has changed and renders the samples. Returns false if there is
// nothing to show.
bool Runner::render(Turn& turn, Signs::Work& signs) {
  Track& track = *turn.track;
  Ledger& ledger = track.ledger;
  track.renderer->set_precedence(
      options_.device_queues ? static_cast<unsigned>(first_picture(ledger)) : turn.precedence);
  if (ledger.stale()) {
    const double before = own_seconds(turn);
    track.renderer->prepare_denoising(!ledger.wanted().raw);
    auto taken = track.renderer->set_scene(*ledger.wanted().scene, ledger.planned());
    turn.scene_seconds = own_seconds(turn) - before;
    if (!taken) {
      turn.refused = std::move(taken.error());
      return false;
    }
    ledger.began(turn.scene_seconds, clock_.now());
    track.client->began(ledger.epoch(), ledger.wanted());
  }
  const bool interruptible = ledger.interruptible();
  const auto stop = [&] {
    signs.alive();
    if (stopping_ || track.gone) return true;
    return interruptible && track.client->version() != ledger.applied_version();
  };
  const Time start = clock_.now();
  const double before = own_seconds(turn);
  const auto batch = track.renderer->render(turn.samples, stop);
  if (!batch) {
    turn.failed = batch.error();
    return false;
  }
  const Progress progress = track.renderer->progress();
  const Time now = clock_.now();
  turn.render_seconds = seconds_between(start, now);
  // Charges only the session's own share of the device, because quanta that share it wait for each
  // other.
  Batch own = *batch;
  if (turn.render_seconds > 0) own.seconds *= (own_seconds(turn) - before) / turn.render_seconds;
  {
    const std::lock_guard lock(mutex_);
    ledger.rendered(own, progress, costs_, now);
  }
  if (track.gone) return false;
  track.client->rendered(own);
  return true;
}

void Runner::show_if_due(Turn& turn) {
  Track& track = *turn.track;
  const Time now = clock_.now();
  DeviceCosts costs;
  {
    const std::lock_guard lock(mutex_);
    costs = costs_;
  }
  track.ledger.refresh(track.client->wanted(), costs, options_.rules, now);
  const auto question = track.ledger.emission(options_.rules, now);
  if (question && should_emit(*question)) show(turn, *question);
}

void Runner::show(Turn& turn, const EmissionQuestion& question) {
  Track& track = *turn.track;
  Ledger& ledger = track.ledger;
  if (track.gone) return;
  const Time start = clock_.now();
  const double before = own_seconds(turn);
  RenderedPicture rendered;
  // The converged picture is never denoised: it shows the samples and nothing else.
  const Result<bool> shown =
      question.converged ? track.renderer->display(rendered.picture).map([] { return false; })
                         : track.renderer->display_denoised(rendered.picture);
  if (!shown) {
    turn.failed = shown.error();
    return;
  }
  rendered.info.epoch = ledger.epoch();
  // If an update changed nothing, the same picture answers it under the new input's number.
  rendered.info.input_seq = ledger.stale() ? ledger.input_seq() : ledger.wanted().input_seq;
  rendered.info.samples = ledger.progress().samples;
  rendered.info.error = ledger.progress().error;
  rendered.info.first_of_epoch = ledger.samples_shown() == 0;
  rendered.info.moving = ledger.moving();
  rendered.info.converged = question.converged;
  rendered.info.denoised = *shown;
  turn.picture_seconds = seconds_between(start, clock_.now());
  const double own = own_seconds(turn) - before;
  rendered.info.render_us =
      static_cast<std::uint64_t>((ledger.scene_seconds() + ledger.progress().seconds + own) * 1e6);
  {
    const std::lock_guard lock(mutex_);
    ledger.shown(own, costs_, start);
  }
  track.client->picture(std::move(rendered));
  if (ledger.wanted().kernel_report) track.client->kernel(track.renderer->report());
}

void Runner::drop(Track& track, const Error& why) {
  track.gone = true;
  track.client->failed(why);
  if (why.code == ErrorCode::kDeviceLost && options_.device_lost) options_.device_lost(why);
}

}  // namespace diaphane::render
