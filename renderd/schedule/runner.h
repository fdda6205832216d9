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
#include "renderd/schedule/in_flight.h"
#include "renderd/schedule/lanes.h"
#include "renderd/schedule/ledger.h"
#include "renderd/schedule/policy.h"
#include "renderd/schedule/signs.h"
#include "renderd/schedule/still_turns.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

/// A picture without a session (thumbnails), rendered in the pauses of the sessions.
struct StillJob {
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  std::uint32_t samples = 1;
  /// Estimated, at which the picture is good enough before it has all samples; 0: never.
  double error = 0;
  StillRank rank = StillRank::kAwaited;
  bool smoothed = false;  ///< as the first pictures of a session are
  /// Its submitter may use it again in `done`, or after it.
  std::shared_ptr<FrameRenderer> renderer;
  /// When somebody must have the picture: it is given with the samples that it has by then, one at
  /// least. Otherwise a busy device would begin it anew with each request and never end it.
  std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max();
  /// Asked between quanta and within: nobody waits for it any more.
  std::function<bool()> cancelled;
  /// What it took of the device: after each quantum, from a lane's thread.
  std::function<void(double seconds)> took;
  /// Called once from the runner's thread, unless it was cancelled.
  std::function<void(Result<PictureRgb8>, double error)> done;
};

/// Where a device's time went, seconds since the start. What is `rendering`, `scenes` and
/// `pictures` goes on at once for several sessions, each counted.
struct RunnerTimes {
  double rendering = 0;  ///< samples
  double scenes = 0;     ///< new epochs: tables prepared and uploaded, films cleared
  double pictures = 0;   ///< tone-mapped, smoothed, read back
  double busy = 0;       ///< anything was under way
  double idle = 0;       ///< nothing was, and nobody gained
  double deciding = 0;   ///< what is wanted, the policy, what is due; beside what is under way
  double policy = 0;     ///< of `deciding`, the policy's own
  std::uint64_t quanta = 0;
  std::uint64_t switches = 0;  ///< quanta of another session than the one before
};

/// One device's thread: asks the policy whose quanta are next and has lanes carry them out. All
/// decisions are pure functions elsewhere (Policy, Ledger, room_for_another, plan_canvas,
/// should_emit); here are the clock, the lock and the renderers. A quantum is a new scene if one is
/// wanted, samples, and the picture if one is due; on a device that queues, the next one is there
/// before it ends.
class Runner {
 public:
  struct Options {
    LedgerRules rules;
    std::size_t lanes = 8;       ///< quanta that are under way together at most
    bool device_queues = false;  ///< as EngineInfo::queues
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

  /// Seconds with anything under way since the start, for the load that the heartbeat tells.
  double busy_seconds() const;
  RunnerTimes times() const;
  /// Of the pictures that somebody sees, each at most 1: how much is still to be rendered.
  double summed_error() const { return error_; }
  /// Sessions of this worker's own that another sample would gain something for.
  std::size_t waiting() const { return waiting_; }
  /// Of each quantum and picture under way.
  const Signs& signs() const { return signs_; }

 private:
  struct Track;
  struct Turn;
  struct Still;
  using Time = Ledger::Time;

  void run();
  void adopt();
  void collect();
  /// True when something was begun that may leave room for more.
  bool step();
  std::vector<SessionView> look();
  void begin(std::unique_ptr<Turn> turn);
  bool begin_still();
  void drop_cancelled_stills();

  // In a lane.
  void carry_out(Turn& turn, Signs::Work& signs);
  bool render(Turn& turn, Signs::Work& signs);
  void rendered(Turn& turn);
  void show_if_due(Turn& turn);
  void show(Turn& turn, const EmissionQuestion& question);
  void carry_out_still(Turn& turn, Signs::Work& signs);
  void render_still(Turn& turn, Signs::Work& signs);
  void finish_still(Turn& turn, Signs::Work& signs);
  double own_seconds() const;
  void ended(std::unique_ptr<Turn> turn);

  void settle(Turn& turn);
  void settle_still(Turn& turn);
  std::chrono::nanoseconds next_rest() const;
  void drop(Track& track, const Error& why);

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
  mutable InFlight in_flight_;
  std::vector<std::unique_ptr<Turn>> ended_;
  DeviceCosts costs_;
  RunnerTimes spent_;
  std::atomic<bool> stopping_{false};
  std::atomic<double> error_{0};
  std::atomic<std::size_t> moving_{0};  // sessions; set by the thread
  std::atomic<std::size_t> waiting_{0};
  Signs signs_;

  // Of the thread alone.
  std::vector<std::shared_ptr<Track>> tracks_;
  std::deque<std::shared_ptr<Still>> stills_;
  bool still_under_way_ = false;
  std::uint64_t last_ = 0;  // whose quantum was begun last
  double still_share_ = 0;
  double still_seconds_due_ = 0;  // of the device, to the stills
  double busy_told_ = 0;          // for that
  Lanes lanes_;                   // ends before what its work touches
  std::thread thread_;
};

}  // namespace diaphane::render
