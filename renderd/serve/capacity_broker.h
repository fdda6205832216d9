#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "directory/lending.h"
#include "directory/worker.h"
#include "renderd/serve/grpc_assistants.h"

namespace diaphane::render {

/// Describes a peer to a worker on `node` whose sessions view `volumes`.
directory::PeerLoad load_of(const directory::Peer& peer, const std::string& node,
                            const std::vector<std::string>& volumes);

/// Borrows capacity from peers while this worker's sessions need more than its device, and reports
/// to them the capacity it lends (docs/adr/0033). directory/lending.h chooses the peers. Has its
/// own thread, and uses Redis only while something is borrowed, lent or needed.
class CapacityBroker {
 public:
  using Helper = directory::Helper;
  using Lending = directory::Lending;
  using PeerLoad = directory::PeerLoad;

  struct Options {
    std::string worker_id;
    std::string incarnation;
    std::string address;  ///< address at which peers reach this worker
    std::string node;     ///< directory::Heartbeat::node
    std::string owner;    ///< only workers of the same fleet help each other
    directory::LendingRules rules;
    std::chrono::milliseconds period{1000};
    std::function<double()> busy_seconds;  ///< busy time of the device since the start
    std::function<double()> lent_seconds;  ///< part of the busy time spent on other workers'
                                           ///< pictures
    std::function<double()> waiting;       ///< sessions per device that have not converged
    std::function<std::vector<std::string>()> volumes;  ///< loaded volumes
    std::function<void(std::size_t borrowed)> updated;  ///< called after each update
  };

  /// Starts to borrow and to report. If `helpers` is null, no peers are borrowed and only lent
  /// capacity is reported. `redis` and `helpers` must outlive this object.
  CapacityBroker(Options options, directory::Client& redis, GrpcAssistants* helpers);
  /// Releases all borrowed workers.
  ~CapacityBroker();
  CapacityBroker(const CapacityBroker&) = delete;
  CapacityBroker& operator=(const CapacityBroker&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  /// Shares of device time since the last update.
  struct Use {
    double seconds = 0, asked = 0, lent = 0, helped = 0;
    bool waits = false;  ///< whether own sessions wait, and not only thumbnails
  };

  void run();
  void update();
  Use use();
  bool looks_for_helpers(const Use& use) const;
  std::vector<PeerLoad> observed_peers(const Use& use);
  void note_refusals();
  void borrow(const Lending& before);

  const Options options_;
  GrpcAssistants* const helpers_;
  directory::WorkerDirectory directory_;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;

  // Used only by the thread.
  Clock::time_point since_;
  double busy_before_ = 0, lent_before_ = 0, helped_before_ = 0;
  double waited_ = 0;  ///< sum of waiting sessions since the last update
  std::size_t ticks_ = 0;
  bool lent_reported_ = false;
  Lending lending_;
  std::map<std::string, std::string> addresses_;      ///< addresses of the peers in the last answer
  std::map<std::string, Clock::time_point> avoided_;  ///< peers to avoid, by id, and until when
  std::mt19937_64 random_{std::random_device{}()};
  std::thread thread_;
};

}  // namespace diaphane::render
