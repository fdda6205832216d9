#pragma once

#include <cstdint>

#include "common/result.h"

namespace diaphane {

/// Limits and descriptors of a child.
struct SandboxLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< address space (RLIMIT_AS)
  /// Maximum size of any file that the child writes (RLIMIT_FSIZE).
  std::uint64_t output_bytes = std::uint64_t{2} << 30;
  std::uint32_t cpu_seconds = 300;  ///< RLIMIT_CPU
  int input = 3;                    ///< the only descriptor that may be read (supervisor.h)
  int last_output = 5;              ///< highest descriptor that may be written or exist
};

/// Restricts this process to computing, reading its input, writing its outputs and ending. A short
/// list of calls that libraries make without need (opening a file, querying one, creating a thread)
/// fails with EACCES. Every other call ends the process at once (SIGSYS): sockets, programs,
/// signals to others, removing or renaming files, executable memory, and any call that is not
/// listed. The process cannot gain privileges, writes no core file and cannot leave the sandbox.
/// Returns kInternal if the kernel refuses; the process must then read nothing.
Result<void> enter_sandbox(const SandboxLimits& limits);

}  // namespace diaphane
