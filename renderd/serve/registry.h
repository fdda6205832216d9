#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "directory/worker.h"
#include "renderd/serve/expected_load.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/session_host.h"

namespace diaphane::render {

/// Keeps this worker registered in Redis (docs/contracts.md): one heartbeat per second, and the
/// scenes of its sessions at most every 200 ms. Has its own thread, so that an unavailable or slow
/// Redis blocks nothing. Sessions continue meanwhile, and unwritten data is written later.
class Registry {
 public:
  struct Options {
    std::string worker_id;
    std::string incarnation;  ///< different at each start
    std::string address;      ///< address at which the gateway reaches this worker
    std::string engine;
    std::string device;
    std::string node;                                   ///< directory::Heartbeat::node
    std::function<double()> busy_seconds;               ///< busy time since the start, for the load
    std::function<std::vector<std::string>()> volumes;  ///< loaded volumes
    /// Called once, from the registry's thread, when another live worker has used this name for
    /// longer than a dead worker stays registered.
    std::function<void(const std::string& address)> name_taken;
    std::string owner;               ///< owner of this worker for an operator; empty: none
    std::function<double()> memory;  ///< used share of the memory for loaded volumes, 0 to 1
    std::function<double()> error;   ///< summed over all pictures
    /// Called every second, from the registry's thread, while an operator wants this worker to
    /// drain. `room` sessions can move elsewhere.
    std::function<void(std::size_t room)> drain_ordered;
    /// The part of `busy_seconds` spent on other workers' pictures. It does not count for
    /// placement, because it becomes free when a session is placed here. May be empty.
    std::function<double()> lent_seconds;
  };

  /// Starts to send heartbeats. `redis` must outlive this object.
  Registry(Options options, directory::Client& redis, SessionHost& host, Metrics& metrics);
  /// Removes the worker from the list of workers.
  ~Registry();
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /// Announces that the worker accepts no new sessions, and writes unsaved scenes. Returns when
  /// that is done or after `timeout`.
  void drain(std::chrono::milliseconds timeout);
  /// Returns whether the last heartbeat succeeded.
  bool connected() const { return connected_; }

 private:
  /// Share of the device; 1 is the whole device.
  struct Loads {
    double busy = 0;      ///< share since the last heartbeat
    double expected = 0;  ///< share that is expected in the future
  };
  void run();
  bool heartbeat();
  bool save_scenes();
  void report_render_time();
  void report_telemetry();
  void write_again(const std::string& session);
  void refused_name(const std::string& holder);
  Loads loads(const std::vector<SessionHost::Live>& live);

  const Options options_;
  SessionHost& host_;
  Metrics& metrics_;
  directory::WorkerDirectory directory_;
  std::atomic<bool> connected_{false};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool draining_ = false;
  bool drain_reported_ = false;

  // Used only by the thread.
  double busy_before_ = 0, lent_before_ = 0;
  ExpectedLoad expected_;
  std::chrono::steady_clock::time_point load_since_;
  std::optional<std::chrono::steady_clock::time_point> refused_since_;
  bool refusal_reported_ = false;
  bool drain_ordered_ = false;  // never reset, because this worker never accepts sessions again
  std::thread thread_;
};

}  // namespace diaphane::render
