#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/load/child.h"
#include "bench/load/scrape.h"
#include "common/result.h"
#include "tests/support/common/claimed_port.h"

namespace diaphane::api::load {

/// Resources that the programs have used since their start.
struct Usage {
  std::chrono::steady_clock::time_point at;
  double renderd = 0, gateway = 0, redis = 0, viewers = 0;  ///< CPU seconds
  Samples worker, streams;                                  ///< metrics of renderd and gateway
};

/// Runs Redis, renderd and the gateway with sockets in a private temporary directory and free
/// loopback ports.
class Stage {
 public:
  struct Options {
    /// Contains diaphane-renderd and diaphane-gateway, and redis-server unless it is in the PATH.
    std::string bin_dir;
    std::string volume_dir;  ///< directory with one stored volume: volume.json and voxels.i16
    std::string engine = "auto";
    std::size_t slots = 8;
    std::vector<std::string> renderd_options;  ///< additional options, for example "--threads=2"
    std::string log_dir;                       ///< empty: the temporary directory
    std::chrono::seconds start{60};            ///< time limit for all programs to become ready
  };
  /// Fails with kUnavailable and the end of the log if a program does not become ready.
  static Result<std::unique_ptr<Stage>> set(Options options);
  ~Stage();

  std::string redis() const { return "unix:" + folder_ + "/redis.sock"; }
  std::uint16_t stream_port() const { return stream_port_; }
  const std::string& origin() const { return origin_; }
  const std::string& volume_id() const { return volume_id_; }
  /// Returns whether all programs are still running.
  bool stands();
  Usage usage() const;

 private:
  Stage() = default;
  Result<void> start_all(const Options& options);
  Result<void> copy_volume(const std::string& volume_dir);
  Result<void> claim_ports();
  Result<void> start_redis(const Options& options);
  Result<void> start_renderd(const Options& options);
  Result<void> start_gateway(const Options& options);
  /// Starts a program and waits until `is_ready` returns true.
  Result<void> start(const char* name, const std::string& program,
                     const std::vector<std::string>& arguments,
                     const std::function<bool()>& is_ready);
  std::string store() const { return folder_ + "/volumes"; }

  std::string folder_, log_dir_, volume_id_, origin_;
  std::uint16_t stream_port_ = 0, gateway_admin_ = 0, renderd_admin_ = 0;
  std::vector<ClaimedPort> ports_;
  std::vector<Child> children_;                     // Redis, renderd, gateway
  std::chrono::steady_clock::time_point start_by_;  // time limit for all programs
};

}  // namespace diaphane::api::load
