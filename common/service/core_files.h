#pragma once

namespace diaphane::service {

/// Disables core files for this process and the processes that it starts. A core file would contain
/// memory such as uploads and outlive their deletion. This cannot be undone.
void forbid_core_files();

}  // namespace diaphane::service
