#pragma once

namespace diaphane {

/// Marks a place where tests can kill the process, to check what SIGKILL leaves behind. If the
/// directory in DIAPHANE_FAULT_DIR contains a file called `name`, removes that file and ends this
/// process with SIGKILL. Because the file is gone, the restarted program passes this place. Without
/// the file, nothing happens.
void fault_point(const char* name);

}  // namespace diaphane
