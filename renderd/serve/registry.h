#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "renderd/serve/expected_load.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/redis_client.h"
#include "renderd/serve/session_host.h"

namespace diaphane::render {

/// This worker in Redis (docs/contracts.md): a heartbeat each second, the scenes of its sessions at
/// most every 200 ms. Has a thread of its own, so that a Redis that is away or slow holds up
/// nothing: sessions go on, and what was not written is written when it is back.
class Registry {
 public:
  struct Options {
    wire::RedisAddress redis;
    std::string worker_id;
    std::string incarnation;  ///< new at each start
    std::string address;      ///< where the gateway finds this worker
    std::string engine;
    std::string device;
    std::function<double()> busy_seconds;               ///< since the start, for the load
    std::function<std::vector<std::string>()> volumes;  ///< loaded
    /// Called once, from the registry's thread: another worker that lives has had this name for
    /// longer than one that died would be remembered.
    std::function<void(const std::string& address)> name_taken;
    std::string owner;               ///< whose this worker is, for an operator; empty: nobody's
    std::function<double()> memory;  ///< of the device, 0 to 1
    std::function<double()> error;   ///< of all pictures, summed
    /// Called each second while an operator wants this worker to drain, from the registry's thread:
    /// `room` sessions find a place elsewhere.
    std::function<void(std::size_t room)> told_to_drain;
    /// Of `busy_seconds`, for other workers' pictures: given back when somebody comes here, so
    /// nothing that a session is placed by. May be empty.
    std::function<double()> lent_seconds;
  };

  Registry(Options options, SessionHost& host, Metrics& metrics);
  /// Takes the worker off the list.
  ~Registry();
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /// No new sessions: told at once, with the scenes that are not written yet. Returns when that is
  /// done or `timeout` has passed.
  void drain(std::chrono::milliseconds timeout);
  /// The last heartbeat was taken.
  bool connected() const { return connected_; }

 private:
  /// Of the device, 1: all of it.
  struct Loads {
    double busy = 0;      ///< since the last heartbeat
    double expected = 0;  ///< from now on
  };
  void run();
  bool heartbeat();
  bool save_scenes();
  void note_render_time();
  void report_to_fleet();
  void write_again(const std::string& session);
  void refused_name(const std::string& holder);
  Loads loads(const std::vector<SessionHost::Live>& live);

  const Options options_;
  SessionHost& host_;
  Metrics& metrics_;
  RedisClient redis_;
  std::atomic<bool> connected_{false};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool draining_ = false;
  bool drain_told_ = false;

  // Of the thread alone.
  double busy_before_ = 0, lent_before_ = 0;
  ExpectedLoad expected_;
  std::chrono::steady_clock::time_point load_since_;
  std::optional<std::chrono::steady_clock::time_point> refused_since_;
  bool refusal_told_ = false;
  bool told_to_drain_ = false;  // for good: it takes no session again
  std::thread thread_;
};

}  // namespace diaphane::render
