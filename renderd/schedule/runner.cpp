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
/// CPU priority of background work.
constexpr int kBackgroundNice = 10;
/// Maximum number of background lanes. Paused work keeps its lane, so each session needs one.
constexpr std::size_t kMostBackground = 256;

bool first_picture(const Ledger& ledger) { return ledger.stale() || ledger.samples_shown() == 0; }

}  // namespace

Runner::Runner(std::unique_ptr<Policy> policy, const Clock& clock, Options options)
    : policy_(std::move(policy)),
      clock_(clock),
      options_(std::move(options)),
      lanes_(options_.lanes),
      background_lanes_(kMostBackground, options_.device_queues ? 0 : kBackgroundNice) {
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
  auto entry = std::make_shared<SessionEntry>(first_epoch);
  entry->client = std::move(client);
  entry->renderer = std::move(renderer);
  std::uint64_t handle = 0;
  {
    const std::lock_guard lock(mutex_);
    handle = entry->handle = next_handle_++;
    known_.push_back(entry);
    arriving_.push_back(std::move(entry));
    ++wakes_;
  }
  changed_.notify_one();
  return handle;
}

void Runner::remove(std::uint64_t handle) {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& entry : known_) {
      if (entry->handle == handle) entry->gone = true;
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
    std::uint64_t last_wake = 0;
    {
      const std::lock_guard lock(mutex_);
      last_wake = wakes_;
    }
    adopt();
    collect();
    if (step()) continue;
    std::unique_lock lock(mutex_);
    const bool idle = in_flight_.count() == 0;
    const Time since = clock_.now();
    changed_.wait_for(lock, next_change(), [&] { return wakes_ != last_wake; });
    if (idle) spent_.idle += seconds_between(since, clock_.now());
  }
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return in_flight_.count() == 0; });
  }
  adopt();
  collect();
  for (const auto& still : stills_) {
    still->job.done(fail(ErrorCode::kUnavailable, "This rendering server is shutting down."), 0);
  }
}

void Runner::adopt() {
  std::vector<std::shared_ptr<SessionEntry>> leaving;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  for (auto& entry : arriving_) entries_.push_back(std::move(entry));
  arriving_.clear();
  for (StillJob& job : arriving_stills_) {
    const auto before = std::find_if(stills_.begin(), stills_.end(),
                                     [&](const auto& still) { return still->job.rank > job.rank; });
    stills_.insert(before, std::make_shared<PendingStill>(PendingStill{std::move(job)}));
  }
  arriving_stills_.clear();
  const auto gone = [](const std::shared_ptr<SessionEntry>& entry) { return entry->gone.load(); };
  std::copy_if(entries_.begin(), entries_.end(), std::back_inserter(leaving), gone);
  std::erase_if(entries_, gone);
  std::erase_if(known_, gone);
}

// Returns the time until the next change that does not wake the thread: a moving session comes to
// rest, or a picture that could overtake others becomes due. Only the policy knows when the second
// happens, so it is asked often.
std::chrono::nanoseconds Runner::next_change() const {
  constexpr std::chrono::milliseconds kBetweenQuestions(4);
  const Time now = clock_.now();
  std::chrono::nanoseconds wait = std::chrono::seconds(1);
  for (const auto& entry : entries_) {
    if (entry->under_way) continue;
    const ViewRequest& requested = entry->ledger.requested();
    const bool asks = entry->ledger.stale() && requested.visible && requested.room;
    if (asks && !options_.device_queues) return kBetweenQuestions;
    if (!entry->ledger.moving() || !requested.visible) continue;
    const Seconds rest = Seconds(kRestSeconds) - (now - requested.last_input);
    wait = std::min(wait, std::chrono::duration_cast<std::chrono::nanoseconds>(
                              std::max(rest, Seconds(0)) + std::chrono::milliseconds(1)));
  }
  return wait;
}

double Runner::busy_seconds() const {
  const std::lock_guard lock(mutex_);
  return in_flight_.needed_seconds(clock_.now());
}

RunnerTimes Runner::times() const {
  const std::lock_guard lock(mutex_);
  RunnerTimes times = spent_;
  times.busy = in_flight_.busy_seconds(clock_.now());
  return times;
}

// Accounts for the work that the lanes have finished.
void Runner::collect() {
  std::vector<std::unique_ptr<WorkItem>> ended;
  double busy = 0;
  {
    const std::lock_guard lock(mutex_);
    ended.swap(ended_);
    busy = in_flight_.busy_seconds(clock_.now());
    for (const auto& item : ended) {
      spent_.scenes += item->scene_seconds;
      spent_.rendering += item->render_seconds;
      spent_.pictures += item->picture_seconds;
    }
  }
  still_seconds_due_ =
      std::min(still_seconds_due_ + still_share_ * (busy - busy_accounted_), kLongestStillSeconds);
  busy_accounted_ = busy;
  for (const auto& item : ended) item->still ? settle_still(*item) : settle(*item);
}

void Runner::settle(WorkItem& item) {
  SessionEntry& entry = *item.entry;
  entry.under_way = false;
  entry.item = nullptr;
  if (item.failed) return drop(entry, *item.failed);
  if (!item.refused) return;
  if (!entry.ledger.has_picture()) return drop(entry, *item.refused);
  entry.ledger.refused();
  entry.client->refused(entry.ledger.requested(), *item.refused);
}

// Reads the current request of every session, and begins pictures that are due although no samples
// are rendered.
std::vector<SessionView> Runner::refresh_views() {
  const Time now = clock_.now();
  DeviceCosts costs;
  {
    const std::lock_guard lock(mutex_);
    costs = costs_;
  }
  std::vector<SessionView> views;
  views.reserve(entries_.size());
  std::size_t moving = 0;
  std::size_t waiting = 0;
  double error = 0;
  bool urgent = !stills_.empty();
  for (const auto& entry : entries_) {
    if (entry->gone) continue;
    Ledger& ledger = entry->ledger;
    if (!entry->under_way) {
      ledger.refresh(entry->client->requested(), costs, options_.rules, now);
      entry->last_view = ledger.view(entry->handle, costs, options_.rules, now);
      entry->moving = ledger.moving() && ledger.requested().visible;
      const auto question = ledger.emission(options_.rules, now);
      if (question && should_emit(*question)) {
        auto item = std::make_unique<WorkItem>();
        item->entry = entry;
        item->question = question;
        item->fill = 0;  // hardly uses the device
        begin(std::move(item));
      }
      if (!ledger.requested().scene) continue;
    } else {
      raise_if_awaited(*entry);
    }
    entry->last_view.under_way = entry->under_way;
    entry->last_view.visitor = entry->client->of_visitor();
    entry->last_view.spare = entry->client->with_spare_time();
    if (entry->moving) ++moving;
    if (gains(entry->last_view) && !entry->client->of_another_worker()) ++waiting;
    views.push_back(entry->last_view);
    if (entry->last_view.spare) continue;
    if (gains(entry->last_view)) urgent = true;
    // A session without a first picture has an infinite error; it counts as 1.
    if (entry->last_view.visible) error += std::min(1.0, entry->last_view.error);
  }
  for (SessionView& view : views) view.visible = view.visible && !(view.spare && urgent);
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
  const std::vector<SessionView> views = refresh_views();
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
    const auto chosen = std::find_if(entries_.begin(), entries_.end(), [&](const auto& entry) {
      return entry->handle == quantum.session;
    });
    if (chosen == entries_.end()) continue;
    auto item = std::make_unique<WorkItem>();
    item->entry = *chosen;
    item->samples = quantum.samples;
    const Ledger& ledger = item->entry->ledger;
    if (!options_.device_queues && first_picture(ledger) && !item->entry->last_view.spare) {
      item->precedence = first_picture_precedence(item->entry->last_view);
    }
    const double parallel = options_.rules.device_parallel;
    const Canvas canvas = ledger.planned();
    const double work = double(canvas.width) * canvas.height * quantum.samples;
    item->fill = parallel > 0 ? std::min(1.0, work / parallel) : 1;
    begin(std::move(item));
  }
  return quanta.empty() ? room && begin_still() : true;
}

// Raises the precedence of work in flight if a newer input of its session waits for its end.
// Otherwise the input would wait for the first pictures of other sessions.
void Runner::raise_if_awaited(SessionEntry& entry) {
  if (options_.device_queues || entry.client->version() == entry.version_under_way) return;
  const unsigned precedence = first_picture_precedence(entry.last_view);
  {
    const std::lock_guard lock(mutex_);
    WorkItem& item = *entry.item;
    if (item.ended || item.precedence >= precedence) return;
    item.seconds_before_raise += in_flight_.raise(clock_.now(), item.precedence, precedence);
    item.precedence = precedence;
  }
  entry.renderer->raise_precedence(precedence);
}

Lanes& Runner::lanes_for(const WorkItem& item) {
  return options_.device_queues || item.precedence > 0 ? lanes_ : background_lanes_;
}

void Runner::begin(std::unique_ptr<WorkItem> item) {
  if (item->entry) {
    SessionEntry& entry = *item->entry;
    entry.under_way = true;
    entry.item = item.get();
    entry.version_under_way = entry.ledger.requested().version;
    entry.renderer->set_precedence(options_.device_queues
                                       ? item->samples > 0 && first_picture(entry.ledger)
                                       : item->precedence);
  }
  if (item->still) still_under_way_ = true;
  item->spare = item->entry && item->entry->client->with_spare_time();
  {
    const std::lock_guard lock(mutex_);
    in_flight_.begin(item->fill, clock_.now(), item->precedence, item->spare);
    if (item->entry && item->samples > 0) {
      ++spent_.quanta;
      spent_.switches += last_ != item->entry->handle;
      last_ = item->entry->handle;
    }
  }
  // The closure owns the item as a raw pointer, because std::function requires copyable closures.
  lanes_for(*item).start([this, item = item.release()] {
    std::unique_ptr<WorkItem> mine(item);
    {
      ProgressMonitor::Work work(progress_);
      mine->still ? carry_out_still(*mine, work) : carry_out(*mine, work);
    }
    ended(std::move(mine));
  });
}

void Runner::ended(std::unique_ptr<WorkItem> item) {
  rendered(*item);
  // Notifies under the lock, because the runner may be destroyed once its last item has ended.
  const std::lock_guard lock(mutex_);
  in_flight_.end(clock_.now(), item->precedence, item->spare);
  item->ended = true;
  ended_.push_back(std::move(item));
  ++wakes_;
  changed_.notify_one();
}

double Runner::own_seconds(const WorkItem& item) const {
  const std::lock_guard lock(mutex_);
  return item.seconds_before_raise + in_flight_.own_seconds(clock_.now(), item.precedence);
}

void Runner::carry_out(WorkItem& item, ProgressMonitor::Work& work) {
  if (item.question) return show(item, *item.question);
  const bool there = render(item, work);
  // A device that queues continues with other quanta while the picture is made. On the CPU, the
  // picture is made by the threads that render.
  if (options_.device_queues) rendered(item);
  if (there) show_if_due(item);
}

void Runner::rendered(WorkItem& item) {
  if (item.fill == 0) return;
  const std::lock_guard lock(mutex_);
  in_flight_.rendered(std::exchange(item.fill, 0), clock_.now());
  ++wakes_;
  changed_.notify_one();
}

// Prepares the requested scene if it has changed and renders the samples. Returns false if there is
// nothing to show.
bool Runner::render(WorkItem& item, ProgressMonitor::Work& work) {
  SessionEntry& entry = *item.entry;
  Ledger& ledger = entry.ledger;
  if (ledger.stale()) {
    const double before = own_seconds(item);
    entry.renderer->prepare_denoising(!ledger.requested().raw);
    auto taken = set_scene(*entry.renderer, ledger.requested().volume, *ledger.requested().scene,
                           ledger.planned());
    item.scene_seconds = own_seconds(item) - before;
    if (!taken) {
      item.refused = std::move(taken.error());
      return false;
    }
    ledger.began(item.scene_seconds, clock_.now());
    entry.client->began(ledger.epoch(), ledger.requested());
  }
  const bool interruptible = ledger.interruptible();
  const auto stop = [&] {
    work.heartbeat();
    if (stopping_ || entry.gone) return true;
    return interruptible && entry.client->version() != ledger.applied_version();
  };
  const Time start = clock_.now();
  const double before = own_seconds(item);
  const auto batch = entry.renderer->render(item.samples, stop);
  if (!batch) {
    item.failed = batch.error();
    return false;
  }
  const Progress progress = entry.renderer->progress();
  const Time now = clock_.now();
  item.render_seconds = seconds_between(start, now);
  // Charges only the session's own share of the device, because quanta that share it wait for each
  // other.
  Batch own = *batch;
  if (item.render_seconds > 0) own.seconds *= (own_seconds(item) - before) / item.render_seconds;
  {
    const std::lock_guard lock(mutex_);
    ledger.rendered(own, progress, costs_, now);
  }
  if (entry.gone) return false;
  entry.client->rendered(own);
  Progress since_epoch = progress;
  since_epoch.seconds += ledger.scene_seconds();
  entry.client->progressed(since_epoch, ledger.moving());
  return true;
}

void Runner::show_if_due(WorkItem& item) {
  SessionEntry& entry = *item.entry;
  const Time now = clock_.now();
  DeviceCosts costs;
  {
    const std::lock_guard lock(mutex_);
    costs = costs_;
  }
  entry.ledger.refresh(entry.client->requested(), costs, options_.rules, now);
  const auto question = entry.ledger.emission(options_.rules, now);
  if (question && should_emit(*question)) show(item, *question);
}

void Runner::show(WorkItem& item, const EmissionInput& question) {
  SessionEntry& entry = *item.entry;
  Ledger& ledger = entry.ledger;
  if (entry.gone) return;
  const Time start = clock_.now();
  const double before = own_seconds(item);
  RenderedPicture rendered;
  // The converged picture is never denoised: it shows the samples and nothing else.
  const Result<bool> shown =
      question.converged ? entry.renderer->display(rendered.picture).map([] { return false; })
                         : entry.renderer->display_denoised(rendered.picture);
  if (!shown) {
    item.failed = shown.error();
    return;
  }
  rendered.info.epoch = ledger.epoch();
  // If an update changed nothing, the same picture answers it under the new input's number.
  rendered.info.input_seq = ledger.stale() ? ledger.input_seq() : ledger.requested().input_seq;
  rendered.info.volume_phase = ledger.volume_phase();
  rendered.info.samples = ledger.progress().samples;
  rendered.info.error = ledger.progress().error;
  rendered.info.stops = ledger.progress().stops;
  rendered.info.first_of_epoch = ledger.samples_shown() == 0;
  rendered.info.moving = ledger.moving();
  rendered.info.converged = question.converged;
  rendered.info.denoised = *shown;
  item.picture_seconds = seconds_between(start, clock_.now());
  const double own = own_seconds(item) - before;
  rendered.info.render_us =
      static_cast<std::uint64_t>((ledger.scene_seconds() + ledger.progress().seconds + own) * 1e6);
  {
    const std::lock_guard lock(mutex_);
    ledger.shown(own, costs_, start);
  }
  entry.client->picture(std::move(rendered));
  if (ledger.requested().kernel_report) entry.client->kernel(entry.renderer->report());
}

void Runner::drop(SessionEntry& entry, const Error& why) {
  entry.gone = true;
  entry.client->failed(why);
  if (why.code == ErrorCode::kDeviceLost && options_.device_lost) options_.device_lost(why);
}

}  // namespace diaphane::render
