#pragma once

namespace diaphane::service {

/// From here on a crash of this process writes no core file: what is in its memory, uploads among
/// it, would outlive their deletion. Irrevocable; also for the processes that it starts.
void forbid_core_files();

}  // namespace diaphane::service
