#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/clock.h"
#include "renderd/schedule/policy.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

/// A picture without a session (thumbnails), rendered in the pauses of the sessions.
struct StillJob {
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  std::uint32_t samples = 1;
  std::unique_ptr<FrameRenderer> renderer;
  /// When somebody must have the picture: it is given with the samples that it has by then, one at
  /// least. Otherwise a busy device would begin it anew with each request and never end it.
  std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max();
  /// Asked between quanta: nobody waits for it any more.
  std::function<bool()> cancelled;
  /// Called once from the runner's thread, unless it was cancelled.
  std::function<void(Result<PictureRgb8>, double error)> done;
};

/// One device's thread: asks the policy whose quantum is next and carries it out. All decisions are
/// pure functions elsewhere (Policy, plan_canvas, should_emit, may_interrupt); here are the clock,
/// the lock and the renderers.
class Runner {
 public:
  struct Options {
    double target_error = 0.01;         ///< relative RMSE at which a picture counts as converged
    std::uint64_t fewest_samples = 16;  ///< below it the error estimate is not trusted to stop
    std::uint64_t most_samples = 1 << 20;
    /// The device's context is broken: nothing on it can go on.
    std::function<void(const Error&)> device_lost;
  };

  Runner(std::unique_ptr<Policy> policy, const Clock& clock, Options options);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  /// Begins to render for `client`. Its epochs rise from above `first_epoch`. Returns a handle.
  std::uint64_t add(std::shared_ptr<RenderClient> client, std::unique_ptr<FrameRenderer> renderer,
                    std::uint64_t first_epoch);
  /// Returns at once; the quantum under way is cut short and its result dropped.
  void remove(std::uint64_t handle);
  /// A client's `wanted` has changed.
  void wake();
  void submit(StillJob job);
  /// Ends the thread: nothing is rendered any more, stills end with kUnavailable. Idempotent.
  void stop();

  /// Seconds spent in quanta since the start, for the load that the heartbeat tells.
  double busy_seconds() const { return busy_seconds_.load(std::memory_order_relaxed); }

 private:
  struct Track;
  using Time = std::chrono::steady_clock::time_point;

  void run();
  void adopt();
  /// True when something was done that may call for more.
  bool step();
  void refresh(Track& track, Time now);
  void emit_if_due(Track& track, Time now);
  void apply_wanted(Track& track);
  void quantum(Track& track, std::uint32_t samples);
  bool still_quantum();
  SessionView view_of(const Track& track, Time now) const;
  double seconds_per_pixel(const Track& track) const;
  bool converged(const Track& track) const;
  std::chrono::nanoseconds next_rest() const;
  void drop(Track& track, const Error& why);

  const std::unique_ptr<Policy> policy_;
  const Clock& clock_;
  const Options options_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t wakes_ = 0;
  std::vector<std::shared_ptr<Track>> arriving_;
  std::vector<std::shared_ptr<Track>> known_;  // what `remove` looks in
  std::deque<StillJob> arriving_stills_;
  std::uint64_t next_handle_ = 1;
  std::atomic<bool> stopping_{false};
  std::atomic<double> busy_seconds_{0};

  // Of the thread alone.
  std::vector<std::shared_ptr<Track>> tracks_;
  std::deque<StillJob> stills_;
  double seconds_per_pixel_ =
      0;  // of this device, whoever was last: what a new session starts from
  double still_share_ = 0;
  double still_seconds_due_ = 0;     // of the device, to the stills
  std::uint64_t still_samples_ = 0;  // of the first of `stills_`
  std::thread thread_;
};

/// Whether a quantum may be cut short because newer input came: always, but for the first picture
/// of a moving epoch. That one is finished, since input comes faster than a slow device renders,
/// and a picture begun anew with each input would never be shown.
bool may_interrupt(bool began_moving, bool shown);

}  // namespace diaphane::render
