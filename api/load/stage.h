#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/load/child.h"
#include "api/load/scrape.h"
#include "common/claimed_port.h"
#include "common/result.h"

namespace diaphane::api::load {

/// What the programs used, all since their start.
struct Usage {
  std::chrono::steady_clock::time_point at;
  double renderd = 0, gateway = 0, redis = 0, viewers = 0;  ///< processor seconds
  Samples worker, streams;                                  ///< metrics of renderd and gateway
};

/// Redis, renderd and gateway on sockets in a private temporary directory, and on free ports of the
/// loopback.
class Stage {
 public:
  struct Options {
    std::string bin_dir;  ///< diaphane-renderd, diaphane-gateway; redis-server there or in the PATH
    std::string volume_dir;  ///< one volume of the store: volume.json and voxels.i16
    std::string engine = "auto";
    std::size_t slots = 8;
    std::vector<std::string> renderd_options;  ///< further ones, "--threads=2"
    std::string log_dir;                       ///< empty: in the temporary directory
    std::chrono::seconds start{60};            ///< for all to be ready
  };
  /// kUnavailable with the end of a log when a program does not become ready.
  static Result<std::unique_ptr<Stage>> set(Options options);
  ~Stage();

  std::string redis() const { return "unix:" + folder_ + "/redis.sock"; }
  std::uint16_t stream_port() const { return stream_port_; }
  const std::string& origin() const { return origin_; }
  const std::string& volume_id() const { return volume_id_; }
  /// All programs still run.
  bool stands();
  Usage usage() const;

 private:
  Stage() = default;
  Result<void> start_all(const Options& options);

  std::string folder_, log_dir_, volume_id_, origin_;
  std::uint16_t stream_port_ = 0, gateway_admin_ = 0, renderd_admin_ = 0;
  std::vector<ClaimedPort> ports_;
  std::vector<Child> children_;  // Redis, renderd, gateway
};

}  // namespace diaphane::api::load
