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
#include "renderd/schedule/lanes.h"
#include "renderd/schedule/ledger.h"
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

/// Where a device's time went, seconds since the start.
struct RunnerTimes {
  double rendering = 0;  ///< samples; rounds of several sessions count once
  double scenes = 0;     ///< new epochs: tables prepared and uploaded, films cleared
  double pictures = 0;   ///< tone-mapped, smoothed, read back
  double deciding = 0;   ///< what is wanted, the policy, what is due: between two quanta
  double policy = 0;     ///< of `deciding`, the policy's own
  double idle = 0;       ///< nobody gained
  std::uint64_t rounds = 0;
  std::uint64_t quanta = 0;
  std::uint64_t switches = 0;  ///< rounds of other sessions than the round before
};

/// One device's thread: asks the policy whose quanta are next and carries them out. All decisions
/// are pure functions elsewhere (Policy, Ledger, plan_canvas, should_emit); here are the clock, the
/// lock and the renderers. Quanta of one round go to the device together, each by a lane.
class Runner {
 public:
  struct Options {
    LedgerRules rules;
    std::size_t lanes = 8;  ///< quanta that go to the device together at most
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
  RunnerTimes times() const;

 private:
  struct Track;
  struct Turn;
  using Time = Ledger::Time;

  void run();
  void adopt();
  /// True when something was done that may call for more.
  bool step();
  std::vector<SessionView> look(Time now);
  void emit_if_due(Track& track, Time now);
  bool round(const std::vector<Quantum>& quanta);
  void carry_out(Turn& turn) const;
  void settle(Turn& turn, double share);
  bool still_quantum();
  std::chrono::nanoseconds next_rest() const;
  void drop(Track& track, const Error& why);
  void busy(double seconds);
  void tell_times();

  const std::unique_ptr<Policy> policy_;
  const Clock& clock_;
  const Options options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t wakes_ = 0;
  std::vector<std::shared_ptr<Track>> arriving_;
  std::vector<std::shared_ptr<Track>> known_;  // what `remove` looks in
  std::deque<StillJob> arriving_stills_;
  std::uint64_t next_handle_ = 1;
  RunnerTimes told_;  // a copy of `spent_` for others
  std::atomic<bool> stopping_{false};
  std::atomic<double> busy_seconds_{0};

  // Of the thread alone.
  std::vector<std::shared_ptr<Track>> tracks_;
  std::deque<StillJob> stills_;
  DeviceCosts costs_;
  Lanes lanes_;
  std::vector<std::uint64_t> last_round_;  // handles
  RunnerTimes spent_;
  double still_share_ = 0;
  double still_seconds_due_ = 0;     // of the device, to the stills
  std::uint64_t still_samples_ = 0;  // of the first of `stills_`
  std::thread thread_;
};

}  // namespace diaphane::render
