#pragma once

#include <cstdint>

#include "common/result.h"

namespace diaphane::ingest {

/// What a child may use.
struct SandboxLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< of address space (RLIMIT_AS)
  std::uint64_t output_bytes = std::uint64_t{2} << 30;  ///< of any file it writes (RLIMIT_FSIZE)
  std::uint32_t cpu_seconds = 300;                      ///< RLIMIT_CPU
};

/// From here on this process can compute, read and write what it has open, and end; nothing else:
/// no file can be opened, no socket made, no program started, no process or thread made or
/// signalled, and no privilege gained. What is not on the list fails with EACCES; sockets, programs
/// and the like end the process. Irrevocable. kInternal when the kernel refuses, and then nothing
/// may be read.
Result<void> enter_sandbox(const SandboxLimits& limits);

}  // namespace diaphane::ingest
