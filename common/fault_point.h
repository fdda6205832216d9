#pragma once

namespace diaphane {

/// For tests of what a kill -9 leaves behind: a named place in the program where it can be made to
/// die. When DIAPHANE_FAULT_DIR names a directory with a file `name` in it, that file is removed
/// and this process ends by SIGKILL: once, so that the restarted program passes. Else nothing
/// happens.
void fault_point(const char* name);

}  // namespace diaphane
