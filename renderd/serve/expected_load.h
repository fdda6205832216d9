#pragma once

#include <map>
#include <span>
#include <string>

#include "common/expected_share.h"

namespace diaphane::render {

/// Predicts how much of the device this worker's sessions will use, together with its other work
/// (videos, but not pictures for other workers). New sessions are placed by this value.
class ExpectedLoad {
 public:
  struct Usage {
    std::string id;
    /// Device time since the session began; the times of concurrent sessions overlap.
    double device_seconds = 0;
  };

  /// To be called after each heartbeat, which covers `seconds`, of which the device was busy for
  /// `busy`. Returns the expected load; 1 is the whole device.
  double after(double seconds, double busy, std::span<const Usage> sessions, std::size_t slots);

 private:
  struct Watched {
    ExpectedShare share;
    double device_seconds = 0;
  };
  std::map<std::string, Watched> sessions_;
  ExpectedShare other_;
};

}  // namespace diaphane::render
