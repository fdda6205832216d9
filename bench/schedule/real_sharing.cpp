// What a device loses by switching between sessions: its samples for several resting sessions
// compared with those for one alone with long quanta.
#include <chrono>
#include <thread>

#include "bench/renderer/timing.h"
#include "bench/schedule/real_run.h"
#include "common/try.h"
#include "renderd/schedule/runner.h"

namespace diaphane::render::bench {
namespace {

constexpr Canvas kCanvas{512, 512};
/// No session reaches this error.
constexpr double kOutOfReach = 1e-9;

class Resting final : public RenderClient {
 public:
  Resting(const v1::Scene& scene, Canvas viewport) {
    wanted_.scene = std::make_shared<v1::Scene>(scene);
    wanted_.viewport = viewport;
    wanted_.version = 1;
    wanted_.input_seq = 1;
    wanted_.last_input = Clock::now() - std::chrono::seconds(10);
  }
  ViewRequest requested() override { return wanted_; }
  std::uint64_t version() const noexcept override { return 1; }
  void began(std::uint64_t, const ViewRequest&) override {}
  void refused(const ViewRequest&, const Error&) override { failed_ = true; }
  void rendered(const Batch& batch) override { samples_ += batch.samples; }
  void picture(RenderedPicture) override {}
  void failed(const Error&) override { failed_ = true; }

  std::uint64_t samples() const { return samples_; }
  bool has_failed() const { return failed_; }

 private:
  ViewRequest wanted_;
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<bool> failed_{false};
};

}  // namespace

Result<double> rate_alone(const Stage& stage, double scale, double seconds) {
  auto renderer = stage.engine.renderer(stage.volume, 1, 0, kLiveMethod);
  DIAPHANE_TRY(renderer);
  const Canvas canvas = scaled(kCanvas, scale);
  const auto taken = (*renderer)->set_scene(stage.scenes.begin()->second, canvas);
  DIAPHANE_TRY(taken);
  const auto never = [] { return false; };
  DIAPHANE_TRY((*renderer)->render(2, never));
  double spent = 0;
  std::uint64_t samples = 0;
  while (spent < seconds) {
    const auto batch = (*renderer)->render(32, never);
    DIAPHANE_TRY(batch);
    spent += batch->seconds;
    samples += batch->samples;
  }
  return static_cast<double>(samples) / spent;
}

Result<double> rate_shared(const Stage& stage, double scale, std::size_t sessions, double seconds) {
  const SystemClock clock;
  Runner::Options options;
  options.rules.target_error = kOutOfReach;
  options.rules.device_parallel = stage.engine.info().parallel;
  options.device_queues = stage.engine.info().queues;
  Runner runner(make_policy(PolicyKind::kMarginalGain), clock, options);
  std::vector<std::shared_ptr<Resting>> viewers;
  for (std::size_t i = 0; i < sessions; ++i) {
    auto renderer = stage.engine.renderer(stage.volume, i + 1, 0, kLiveMethod);
    DIAPHANE_TRY(renderer);
    viewers.push_back(
        std::make_shared<Resting>(stage.scenes.begin()->second, scaled(kCanvas, scale)));
    runner.add(viewers.back(), std::move(*renderer), 0);
  }
  const auto all = [&] {
    std::uint64_t samples = 0;
    for (const auto& viewer : viewers) samples += viewer->samples();
    return samples;
  };
  // Excludes the first pictures, which have other costs.
  const auto sleep = [](double s) {
    std::this_thread::sleep_for(std::chrono::duration<double>(s));
  };
  sleep(0.5 * seconds);
  const auto start = Clock::now();
  const std::uint64_t before = all();
  sleep(seconds);
  const double rate = static_cast<double>(all() - before) / seconds_since(start);
  runner.stop();
  for (const auto& viewer : viewers) {
    if (viewer->has_failed()) return fail(ErrorCode::kInternal, "a session failed");
  }
  return rate;
}

}  // namespace diaphane::render::bench
