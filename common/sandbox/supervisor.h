#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane {

/// Descriptors that are open in a child, besides 0, 1 and 2 (/dev/null).
inline constexpr int kChildInput = 3;   ///< the input, such as an upload, read only
inline constexpr int kChildOutput = 4;  ///< an unnamed file, for the result
inline constexpr int kChildReport = 5;  ///< a pipe, for at most kLongestReport bytes
inline constexpr std::size_t kLongestReport = 60000;

struct ChildCommand {
  std::string program;                 ///< a path
  std::vector<std::string> arguments;  ///< without the name of the program
  int input = -1;                      ///< descriptors of this process that the child inherits
  int output = -1;
  std::chrono::milliseconds time_limit{60000};
};

struct ChildEnd {
  enum class How {
    kExited,
    kCrashed,
    kTimedOut,
    kDelayed,  ///< the time limit passed, but the child had used less than half of it as CPU time
    kStopped
  };
  How how = How::kCrashed;
  int exit_code = 0;
  int signal = 0;
  std::string report;
  std::uint64_t peak_bytes = 0;  ///< maximum resident set size
};

/// Runs a child with an empty environment and no open descriptors but those above, and waits for
/// its end. It is killed at its time limit, when `should_continue` (called every 50 ms) returns
/// false, and by the kernel when the calling thread ends. Returns kInternal if it cannot be
/// started.
Result<ChildEnd> run_child(const ChildCommand& command,
                           const std::function<bool()>& should_continue);

}  // namespace diaphane
