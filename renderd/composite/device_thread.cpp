#include "renderd/composite/device_thread.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "renderd/composite/plan.h"

namespace diaphane::render {
namespace {

using Clock = std::chrono::steady_clock;

/// Time between two checks whether another picture needs a turn.
constexpr double kTurnSeconds = 0.005;
constexpr double kMostSamples = 1024;
/// How often a device that is kept for its own pictures checks whether they still need it.
constexpr std::chrono::milliseconds kPoll{5};
/// How long a device must not have been needed before it helps others.
constexpr std::chrono::milliseconds kCalm{100};

double elapsed_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

/// A picture that the device helps to render. The task and the part are shared by both threads; the
/// rest belongs to the device's thread.
class DeviceThread::Job {
 public:
  Job(std::unique_ptr<FrameRenderer> renderer, std::size_t device)
      : renderer_(std::move(renderer)), device_(device) {}

  void begin(const AssistTask& task) {
    const std::lock_guard lock(mutex_);
    next_task_ = task;
    ++version_;
    part_.reset();
    lost_ = false;
  }
  std::optional<AssistPart> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(part_, std::nullopt);
  }
  bool waits() {
    const std::lock_guard lock(mutex_);
    return part_.has_value();
  }
  bool lost() const { return lost_; }
  bool gone() const { return gone_; }
  void leave() { gone_ = true; }

  /// Takes one turn. Returns false if there is nothing to do.
  bool turn(const std::function<bool()>& interrupted) {
    if (!adopt()) return false;
    PartInput input = asked();
    if (!may_render(input)) return false;
    const auto stop = [&] { return gone_ || version_ != applied_ || interrupted(); };
    auto samples = static_cast<std::uint32_t>(
        per_sample_ > 0 ? std::clamp(kTurnSeconds / per_sample_, 1.0, kMostSamples) : 1);
    // The first pair of samples is awaited, and parts contain pairs.
    if (delivered_ == 0 && held_ < 2) samples = 2;
    samples += (held_ + samples) % 2;
    const auto batch = renderer_->render(samples, stop);
    if (!batch) return fail();
    held_ += batch->samples;
    seconds_ += batch->seconds;
    if (batch->samples > 0) {
      const double now = batch->seconds / batch->samples;
      per_sample_ = per_sample_ > 0 ? 0.6 * per_sample_ + 0.4 * now : now;
    }
    input = asked();
    return part_due(input) && !stop() ? hand_over() : true;
  }

 private:
  /// Starts a new task if there is one. Returns false if there is no task at all or it cannot be
  /// rendered.
  bool adopt() {
    AssistTask before;
    {
      const std::lock_guard lock(mutex_);
      if (!next_task_) return false;
      if (version_ == applied_) return !lost_;
      before = std::exchange(current_, *next_task_);
      applied_ = version_;
    }
    const bool continues = current_.scene == before.scene && current_.canvas == before.canvas &&
                           current_.guided == before.guided && change_share();
    held_ = delivered_ = 0;
    seconds_ = 0;
    since_ = Clock::now();
    if (continues) return true;
    renderer_->prepare_denoising(current_.guided);
    if (current_.volume && !renderer_->set_volume(current_.volume->copy(device_))) return fail();
    if (!renderer_->set_scene(*current_.scene, current_.canvas)) return fail();
    if (!renderer_->set_share(current_.share)) return fail();
    return true;
  }

  /// Takes another share of the same picture without preparing its scene again. What is held of the
  /// previous share is lost.
  bool change_share() {
    if (held_ > 0) {
      FilmPart lost;
      const auto taken = renderer_->take_film_here(lost);
      if (!taken || !*taken) return false;
    }
    return renderer_->set_share(current_.share).has_value();
  }

  PartInput asked() { return {held_, delivered_, elapsed_since(since_), cost_, !waits()}; }

  bool hand_over() {
    const auto begin = Clock::now();
    AssistPart part;
    const auto taken = renderer_->take_film_here(part.film);
    if (!taken) return fail();
    if (!*taken) return true;
    part.epoch = current_.epoch;
    part.sequence = current_.share.sequence;
    part.seconds = seconds_;
    part.bytes = std::uint64_t{part.film.width} * part.film.rows * sizeof(PackedPixel);
    delivered_ += held_;
    held_ = 0;
    seconds_ = 0;
    cost_ = elapsed_since(begin);
    since_ = Clock::now();
    const std::lock_guard lock(mutex_);
    if (version_ == applied_) part_ = std::move(part);
    return true;
  }

  bool fail() {
    const std::lock_guard lock(mutex_);
    if (version_ == applied_) lost_ = true;
    return false;
  }

  std::mutex mutex_;
  std::optional<AssistTask> next_task_;
  std::atomic<std::uint64_t> version_{0};
  std::optional<AssistPart> part_;
  std::atomic<bool> lost_{false};
  std::atomic<bool> gone_{false};

  const std::unique_ptr<FrameRenderer> renderer_;
  const std::size_t device_;
  AssistTask current_;
  std::uint64_t applied_ = 0;
  std::uint64_t held_ = 0, delivered_ = 0;
  double seconds_ = 0;     // device time of the samples that are held
  double per_sample_ = 0;  // 0: unknown
  double cost_ = 0;        // time to deliver a part
  Clock::time_point since_{};
};

class DeviceThread::JobAssistant final : public Assistant {
 public:
  JobAssistant(DeviceThread& thread, std::shared_ptr<Job> job)
      : thread_(thread), job_(std::move(job)) {}
  ~JobAssistant() override {
    job_->leave();
    thread_.wake();
  }
  void begin(const AssistTask& task) override {
    job_->begin(task);
    thread_.wake();
  }
  std::optional<AssistPart> take(const AssistNews&) override {
    auto part = job_->take();
    if (part) thread_.wake();
    return part;
  }
  bool lost() override { return thread_.away_ || job_->lost(); }

 private:
  DeviceThread& thread_;
  std::shared_ptr<Job> job_;
};

DeviceThread::DeviceThread() : thread_([this] { run(); }) {}

DeviceThread::~DeviceThread() {
  stopping_ = true;
  wake();
  thread_.join();
}

std::unique_ptr<Assistant> DeviceThread::assistant(std::unique_ptr<FrameRenderer> renderer,
                                                   std::size_t device) {
  auto job = std::make_shared<Job>(std::move(renderer), device);
  add(job);
  return std::make_unique<JobAssistant>(*this, std::move(job));
}

void DeviceThread::keep_for_own(std::function<bool()> needed) {
  {
    const std::lock_guard lock(needed_mutex_);
    needed_ = std::move(needed);
  }
  wake();
}

bool DeviceThread::needed() {
  const std::lock_guard lock(needed_mutex_);
  return needed_ && needed_();
}

bool DeviceThread::kept() {
  const auto now = Clock::now();
  if (needed()) needed_until_ = now + kCalm;
  return now < needed_until_;
}

void DeviceThread::add(std::shared_ptr<Job> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    ++wakes_;
  }
  changed_.notify_one();
}

void DeviceThread::wake() {
  {
    const std::lock_guard lock(mutex_);
    ++wakes_;
  }
  changed_.notify_one();
}

void DeviceThread::run() {
  std::list<std::shared_ptr<Job>> leaving;  // destroyed outside the lock
  std::vector<std::shared_ptr<Job>> jobs;
  std::uint64_t last_wake = 0;
  while (!stopping_) {
    jobs.clear();
    leaving.clear();
    {
      const std::lock_guard lock(mutex_);
      last_wake = wakes_;
      for (auto job = jobs_.begin(); job != jobs_.end();) {
        const auto next = std::next(job);
        if ((*job)->gone()) leaving.splice(leaving.end(), jobs_, job);
        job = next;
      }
      jobs.assign(jobs_.begin(), jobs_.end());
    }
    bool busy = false;
    if (!(away_ = kept())) {
      const auto interrupted = [this] { return stopping_ || needed(); };
      for (const auto& job : jobs) busy |= job->turn(interrupted);
    }
    if (busy) continue;
    const bool idle = jobs.empty();
    jobs.clear();
    std::unique_lock lock(mutex_);
    const auto woken = [&] { return wakes_ != last_wake; };
    if (away_ && !idle) {
      changed_.wait_for(lock, kPoll, woken);
    } else {
      changed_.wait(lock, woken);
    }
  }
}

}  // namespace diaphane::render
