#include "bench/schedule/real_run.h"

#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include "common/try.h"
#include "renderd/schedule/runner.h"

namespace diaphane::render::bench {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// A user of a trace, with their requests and what they saw.
class Viewer final : public RenderClient {
 public:
  Viewer(const v1::Scene& scene, Canvas viewport, SessionScore& score,
         SteadyClock::time_point start)
      : scene_(scene), score_(score), start_(start) {
    wanted_.viewport = viewport;
  }

  void input(double at, bool last) {
    const std::lock_guard lock(mutex_);
    auto scene = std::make_shared<v1::Scene>(scene_);
    auto& eye = *scene->mutable_camera()->mutable_eye();
    eye.set_x(eye.x() + 40 * std::sin(0.05 * double(wanted_.version)));
    wanted_.scene = std::move(scene);
    wanted_.last_input = SteadyClock::now();
    wanted_.rest = last;
    ++wanted_.input_seq;
    version_ = ++wanted_.version;
    score_.input(at, last);
  }
  void show(bool visible, double at) {
    const std::lock_guard lock(mutex_);
    if (wanted_.visible && !visible) score_.hidden(at);
    if (!wanted_.visible && visible) wanted_.picture_again = true;
    wanted_.visible = visible;
  }
  void leave(double at) {
    const std::lock_guard lock(mutex_);
    if (!left_) score_.ended(at);
    left_ = true;
  }

  ViewRequest requested() override {
    const std::lock_guard lock(mutex_);
    ViewRequest wanted = wanted_;
    if (wanted_.visible) wanted_.picture_again = false;
    return wanted;
  }
  std::uint64_t version() const noexcept override { return version_; }
  void began(std::uint64_t, const ViewRequest& wanted) override {
    const std::lock_guard lock(mutex_);
    // Rendering of an older input does not end the wait of the newest one.
    if (!left_ && wanted.version == wanted_.version) score_.began(now());
  }
  void refused(const ViewRequest&, const Error& why) override { fail_with(why); }
  void rendered(const Batch&) override {}
  void picture(RenderedPicture picture) override {
    const std::lock_guard lock(mutex_);
    if (!left_) score_.frame(now(), picture.info.error);
  }
  void failed(const Error& why) override { fail_with(why); }

  std::optional<Error> failure() const {
    const std::lock_guard lock(mutex_);
    return failure_;
  }

 private:
  double now() const { return std::chrono::duration<double>(SteadyClock::now() - start_).count(); }
  void fail_with(const Error& why) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = why;
  }

  const v1::Scene& scene_;
  SessionScore& score_;
  const SteadyClock::time_point start_;
  mutable std::mutex mutex_;
  ViewRequest wanted_;
  bool left_ = false;
  std::atomic<std::uint64_t> version_{0};
  std::optional<Error> failure_;
};

struct Seat {
  std::shared_ptr<Viewer> viewer;
  std::uint64_t handle = 0;
};

}  // namespace

Result<TraceRun> run_real(const Trace& trace, const Stage& stage, const DeviceModel& model,
                          std::unique_ptr<Policy> policy) {
  using Kind = TraceEvent::Kind;
  std::vector<SessionScore> scores;
  std::vector<std::unique_ptr<FrameRenderer>> renderers;
  for (const TraceSession& session : trace.sessions) {
    scores.emplace_back(model.to_good(session.scene, session.viewport));
    // Prepared before the measurement, which excludes opening sessions.
    auto renderer = stage.engine.renderer(stage.volume, renderers.size() + 1, 0, kLiveMethod);
    DIAPHANE_TRY(renderer);
    renderers.push_back(std::move(*renderer));
  }
  const SystemClock clock;
  Runner::Options options;
  options.rules = stage.rules;
  options.rules.device_parallel = model.parallel;
  options.device_queues = model.queues;
  Runner runner(std::move(policy), clock, options);
  const auto start = SteadyClock::now();
  std::vector<Seat> seats(trace.sessions.size());
  for (const TraceEvent& event : events_of(trace)) {
    std::this_thread::sleep_until(start + std::chrono::duration_cast<SteadyClock::duration>(
                                              std::chrono::duration<double>(event.at)));
    const TraceSession& session = trace.sessions[event.session];
    Seat& seat = seats[event.session];
    if (event.kind == Kind::kArrive) {
      seat.viewer = std::make_shared<Viewer>(stage.scenes.at(session.scene), session.viewport,
                                             scores[event.session], start);
      seat.viewer->input(event.at, true);
      seat.handle = runner.add(seat.viewer, std::move(renderers[event.session]), 0);
      continue;
    }
    if (event.kind == Kind::kInput) seat.viewer->input(event.at, event.last);
    if (event.kind == Kind::kHide) seat.viewer->show(false, event.at);
    if (event.kind == Kind::kShow) seat.viewer->show(true, event.at);
    if (event.kind == Kind::kLeave) {
      seat.viewer->leave(event.at);
      runner.remove(seat.handle);
    }
    runner.wake();
  }
  runner.stop();
  for (const Seat& seat : seats) {
    if (seat.viewer && seat.viewer->failure()) return tl::unexpected(*seat.viewer->failure());
  }
  const RunnerTimes spent = runner.times();
  const double seconds = std::chrono::duration<double>(SteadyClock::now() - start).count();
  DeviceTime time;
  // Several kinds of work overlap, so the busy time is divided between them in proportion.
  const double lanes = std::max(spent.rendering + spent.scenes + spent.pictures, 1e-9);
  time.rendering = spent.busy * spent.rendering / lanes;
  time.scenes = spent.busy * spent.scenes / lanes;
  time.pictures = spent.busy * spent.pictures / lanes;
  time.idle = spent.idle;
  // Time without work although sessions would have gained. Losses between two quanta on a busy
  // device appear only in rate_shared.
  time.switching = std::max(seconds - spent.busy - spent.idle, 0.0);
  time.quanta = spent.quanta;
  return TraceRun{score(scores, time, trace.seconds), time};
}

}  // namespace diaphane::render::bench
