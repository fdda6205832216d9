#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.h"

namespace diaphane::directory {

/// A live worker, as of its last heartbeat.
struct WorkerInfo {
  std::string id;
  std::string address;      ///< host:port of its gRPC server
  std::string incarnation;  ///< random value, new at each start
  std::uint32_t slots = 0, used = 0;
  bool draining = false;             ///< accepts no new sessions
  std::vector<std::string> volumes;  ///< IDs of the loaded volumes
  std::string engine = {}, device = {};
  double load = 0;  ///< load in the last second, 0 to 1
};

/// The workers as seen by the gateway and the thumbnails. Implemented with Redis
/// (directory/sessions.h). Thread-safe. Every function returns kUnavailable if Redis is unavailable
/// and recovers automatically.
class Workers {
 public:
  virtual ~Workers() = default;
  /// Returns the workers with a fresh heartbeat.
  virtual Result<std::vector<WorkerInfo>> alive() = 0;
  /// Marks this incarnation as unreachable, so that it gets no sessions until its next heartbeat.
  /// Returns true if it was still known.
  virtual Result<bool> lost(std::string_view worker_id, std::string_view incarnation) = 0;
};

/// Rendering time that workers have reported but nobody has collected yet. Implemented with Redis.
/// Returns kUnavailable if Redis is unavailable.
class SpentRenderTime {
 public:
  virtual ~SpentRenderTime() = default;
  /// Collects milliseconds per user. Collected time is removed, so it is counted only once.
  virtual Result<std::vector<std::pair<std::string, std::int64_t>>> take_render_time() = 0;
};

}  // namespace diaphane::directory
