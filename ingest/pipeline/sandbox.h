#pragma once

#include <cstdint>

#include "common/result.h"

namespace diaphane::ingest {

/// What a child may use.
struct SandboxLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< of address space (RLIMIT_AS)
  std::uint64_t output_bytes = std::uint64_t{2} << 30;  ///< of any file it writes (RLIMIT_FSIZE)
  std::uint32_t cpu_seconds = 300;                      ///< RLIMIT_CPU
  int input = 3;        ///< the one descriptor that may be read (supervisor.h)
  int last_output = 5;  ///< descriptors up to this one may be written, and none above be made
};

/// From here on this process can compute, read its input, write its outputs, and end; nothing else.
/// A short list of calls that libraries make without need (opening a file, asking about one, making
/// a thread) fails with EACCES; every other one ends the process at once (SIGSYS): sockets,
/// programs, signals to others, removing or renaming files, memory that could be run, and all that
/// nobody thought of. No privilege can be gained, no core file is written. Irrevocable. kInternal
/// when the kernel refuses, and then nothing may be read.
Result<void> enter_sandbox(const SandboxLimits& limits);

}  // namespace diaphane::ingest
