#pragma once

#include <map>
#include <span>
#include <string>

#include "common/expected_share.h"

namespace diaphane::render {

/// What the sessions of this worker are expected to take of its device, and what else goes on there
/// (films; not pictures for other workers' sessions): what the next session is placed by.
class ExpectedLoad {
 public:
  struct Seen {
    std::string id;
    double device_seconds = 0;  ///< since the session began; several may be under way together
  };

  /// After each heartbeat's `seconds`, of which the device was busy for `busy`. 1: all of it.
  double after(double seconds, double busy, std::span<const Seen> sessions, std::size_t slots);

 private:
  struct Watched {
    ExpectedShare share;
    double device_seconds = 0;
  };
  std::map<std::string, Watched> sessions_;
  ExpectedShare other_;
};

}  // namespace diaphane::render
