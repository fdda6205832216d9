#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace diaphane::api {

/// A render worker that lives, as its last heartbeat said.
struct WorkerInfo {
  std::string id;
  std::string address;      ///< host:port of its gRPC
  std::string incarnation;  ///< random, new at each start
  std::uint32_t slots = 0, used = 0;
  bool draining = false;             ///< takes no more work
  std::vector<std::string> volumes;  ///< ids of those that it has loaded
  std::string engine = {}, device = {};
  double load = 0;  ///< 0 to 1, of the last second
};

/// What the gateway and the thumbnails need to know of workers. Implemented over Redis (api/redis).
/// Thread-safe. Every function: kUnavailable when Redis is away (recovers by itself).
class Workers {
 public:
  virtual ~Workers() = default;
  virtual Result<std::vector<WorkerInfo>> alive() = 0;
  /// This incarnation cannot be reached: it is placed on no more, until it is heard of again.
  /// True when it was still known.
  virtual Result<bool> lost(std::string_view worker_id, std::string_view incarnation) = 0;
};

}  // namespace diaphane::api
