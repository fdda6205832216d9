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
#include "renderd/schedule/progress_monitor.h"
#include "renderd/schedule/still_scheduling.h"
#include "renderd/session/view_request.h"

namespace diaphane::render {

/// A still: a picture without a session, such as a thumbnail or a picture for a file. It is
/// rendered while sessions leave the device free, and with a limited share of it otherwise
/// (still_share).
struct StillJob {
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  std::uint32_t samples = 1;
  /// Estimated error at which the picture is good enough even if it does not have all samples; 0:
  /// none is.
  double error = 0;
  StillRank rank = StillRank::kAwaited;
  bool smoothed = false;  ///< denoised, like the first pictures of a session
  /// The submitter may use it again as soon as `done` is called.
  std::shared_ptr<FrameRenderer> renderer;
  std::shared_ptr<const DeviceVolume> volume;  ///< null: that of the renderer
  /// Deadline of the picture. It is then delivered with the samples that it has, at least one.
  /// Without a deadline a busy device would restart it with each request and never finish it.
  std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max();
  /// Returns true once no caller waits for the picture. Polled between and during quanta.
  std::function<bool()> cancelled;
  /// Receives the device time that each quantum took. Called on a lane's thread.
  std::function<void(double seconds)> took;
  /// Receives the picture and its error. Called once on the runner's thread, unless the job was
  /// cancelled.
  std::function<void(Result<PictureRgb8>, double error)> done;
};

/// How a device spent its time, in seconds since the start. Several sessions can be in the stages
/// `rendering`, `scenes` and `pictures` at once; each of them is counted.
struct RunnerTimes {
  double rendering = 0;  ///< samples
  double scenes = 0;     ///< new epochs: tables prepared and uploaded, films cleared
  double pictures = 0;   ///< tone-mapped, smoothed, read back
  double busy = 0;       ///< at least one quantum was in flight
  double idle = 0;       ///< none was, and no session could gain
  double deciding = 0;   ///< choosing the next quanta, while others are in flight
  double policy = 0;     ///< the part of `deciding` spent in the policy
  std::uint64_t quanta = 0;
  std::uint64_t switches = 0;  ///< quanta of a different session than the previous one
};

/// Schedules one device. Its thread asks the policy for the next quanta and has lanes execute them.
/// All decisions are made by pure functions elsewhere (Policy, Ledger, room_for_another,
/// plan_canvas, should_emit); the runner owns the clock, the lock and the renderers. A quantum
/// prepares the scene if it has changed, renders samples, and makes the picture if one is due. A
/// device that queues gets the next quantum before the current one ends.
class Runner {
 public:
  struct Options {
    LedgerRules rules;
    std::size_t lanes = 8;       ///< maximum number of quanta in flight
    bool device_queues = false;  ///< EngineInfo::queues of the device
    /// Called when the device's context is lost. No further work on the device can succeed.
    std::function<void(const Error&)> device_lost;
  };

  Runner(std::unique_ptr<Policy> policy, const Clock& clock, Options options);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  /// Starts to render for `client` and returns a handle for remove(). Epochs are numbered from
  /// `first_epoch` + 1.
  std::uint64_t add(std::shared_ptr<RenderClient> client, std::unique_ptr<FrameRenderer> renderer,
                    std::uint64_t first_epoch);
  /// Stops rendering for a client. Returns immediately; a quantum in flight is interrupted and its
  /// result discarded.
  void remove(std::uint64_t handle);
  /// Wakes the thread, because RenderClient::requested() of a client has changed.
  void wake();
  void submit(StillJob job);
  /// Ends the thread. Nothing is rendered afterwards, and remaining stills end with kUnavailable.
  /// Idempotent.
  void stop();

  /// Returns the seconds since the start during which at least one quantum was in flight, apart
  /// from those that used spare time. The heartbeat reports the load from it.
  double busy_seconds() const;
  RunnerTimes times() const;
  /// Returns the sum of the errors of all visible pictures, each at most 1, as a measure of the
  /// remaining work.
  double summed_error() const { return error_; }
  /// Returns the number of this worker's own sessions that have not converged; sessions rendered
  /// for other workers do not count.
  std::size_t waiting() const { return waiting_; }
  /// Returns the progress of each quantum and picture in flight, for a watchdog.
  const ProgressMonitor& progress() const { return progress_; }

 private:
  struct SessionEntry;
  struct WorkItem;
  struct PendingStill;
  using Time = Ledger::Time;

  void run();
  void adopt();
  void collect();
  /// Begins the next quanta. Returns true if it began any and there may be room for more.
  bool step();
  std::vector<SessionView> refresh_views();
  void begin(std::unique_ptr<WorkItem> item);
  void raise_if_awaited(SessionEntry& entry);
  Lanes& lanes_for(const WorkItem& item);
  bool begin_still();
  void drop_cancelled_stills();

  // These run on a lane's thread.
  void carry_out(WorkItem& item, ProgressMonitor::Work& work);
  bool render(WorkItem& item, ProgressMonitor::Work& work);
  void rendered(WorkItem& item);
  void show_if_due(WorkItem& item);
  void show(WorkItem& item, const EmissionInput& question);
  void carry_out_still(WorkItem& item, ProgressMonitor::Work& work);
  void render_still(WorkItem& item, ProgressMonitor::Work& work);
  void finish_still(WorkItem& item, ProgressMonitor::Work& work);
  double own_seconds(const WorkItem& item) const;
  void ended(std::unique_ptr<WorkItem> item);

  void settle(WorkItem& item);
  void settle_still(WorkItem& item);
  std::chrono::nanoseconds next_change() const;
  void drop(SessionEntry& entry, const Error& why);

  const std::unique_ptr<Policy> policy_;
  const Clock& clock_;
  const Options options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t wakes_ = 0;
  std::vector<std::shared_ptr<SessionEntry>> arriving_;
  std::vector<std::shared_ptr<SessionEntry>> known_;  // searched by `remove`
  std::deque<StillJob> arriving_stills_;
  std::uint64_t next_handle_ = 1;
  mutable InFlight in_flight_;
  std::vector<std::unique_ptr<WorkItem>> ended_;
  DeviceCosts costs_;
  RunnerTimes spent_;
  std::atomic<bool> stopping_{false};
  std::atomic<double> error_{0};
  std::atomic<std::size_t> moving_{0};  // number of sessions; written by the runner's thread
  std::atomic<std::size_t> waiting_{0};
  ProgressMonitor progress_;

  // Accessed only by the runner's thread.
  std::vector<std::shared_ptr<SessionEntry>> entries_;
  std::deque<std::shared_ptr<PendingStill>> stills_;
  bool still_under_way_ = false;
  std::uint64_t last_ = 0;  // handle of the session whose quantum was begun last
  double still_share_ = 0;
  double still_seconds_due_ = 0;  // device time owed to stills
  double busy_accounted_ = 0;     // busy seconds up to which still_seconds_due_ is computed
  // Destroyed before the members that their work uses. On the CPU, work that a user waits for has
  // lanes of its own, so that it neither waits for paused work to free one nor shares the processor
  // evenly with other work.
  Lanes lanes_;
  Lanes background_lanes_;
  std::thread thread_;
};

}  // namespace diaphane::render
