#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "renderd/engine/frame_renderer.h"
#include "renderd/schedule/runner.h"

namespace diaphane::render {

/// The device and the runner that render a session or a still.
struct Home {
  Engine& engine;
  Runner& runner;
};

/// The state of a device when a picture needs a home.
struct HomeLoad {
  std::size_t waiting = 0;  ///< Runner::waiting
  std::size_t guests = 0;   ///< number of sessions and stills that are at home there
};

/// Returns the index of the device with the fewest waiting sessions, and of these the one with the
/// fewest guests. `loads` must not be empty.
std::size_t choose_home(const std::vector<HomeLoad>& loads);

/// The devices of a worker, each with a runner of its own. Those of a composite engine help each
/// other while their own sessions leave them free. Thread-safe.
class Homes {
 public:
  /// Creates the runner of each device with `runner`. `engine` must outlive this object.
  Homes(Engine& engine, const std::function<std::unique_ptr<Runner>(const Engine&)>& runner);
  ~Homes();

  /// Returns the least loaded home. It counts as taken until the pointer and its copies are gone.
  std::shared_ptr<const Home> take();

  /// Ends all runners (Runner::stop).
  void stop();
  // Means over all devices.
  double busy_seconds() const;
  RunnerTimes times() const;  ///< except the numbers, which are sums
  double waiting() const;
  /// Returns the sum over all devices.
  double summed_error() const;
  std::vector<const ProgressMonitor*> progress() const;

 private:
  struct Device {
    Engine* engine;
    std::unique_ptr<Runner> runner;
    /// Shared with the guests, because a runner may hold the last of them.
    std::shared_ptr<std::atomic<std::size_t>> guests;
  };

  Engine& engine_;
  std::mutex mutex_;  ///< so that two guests do not choose at once
  std::vector<Device> devices_;
};

}  // namespace diaphane::render
